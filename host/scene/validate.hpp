#pragma once

#include <cstddef>
#include <limits>
#include <string>

#include "weft/scene.hpp"

/// The parts of validate(), which weft/scene.hpp declares.
namespace weft {

/// Most steps a frame that a scene may ask for.
inline constexpr double max_steps_per_frame = 1e6;

/// Most vertices or triangles of all meshes together. The largest number made of them has to fit an
/// index: four corners times four of a hinge, one and a half hinges per triangle.
inline constexpr std::size_t most_elements =
    static_cast<std::size_t>(std::numeric_limits<Index>::max()) / 25;

/// Checks that numbers of what is made of all meshes together fit into an index.
/// @throws SceneError
void validate_total(const Scene& scene);

/// Checks one motion: no key or at least two, strictly increasing times, finite, unit axes,
/// positive scales.
/// @param file, field for messages
/// @throws SceneError
void validate_motion(const Motion& motion, const std::string& file, const std::string& field);

/// Checks the ranges of one material.
/// @throws SceneError
void validate_material(const Material& material, const std::string& file, const std::string& field);

}  // namespace weft
