#pragma once

#include <string>

#include "weft/scene.hpp"

/// The parts of validate(), which weft/scene.hpp declares.
namespace weft {

/// Most steps a frame that a scene may ask for.
inline constexpr double max_steps_per_frame = 1e6;

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
