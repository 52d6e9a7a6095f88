#pragma once

#include <optional>
#include <string>

#include "weft/core/vec.hpp"
#include "weft/scene.hpp"

namespace weft::app {

/// Box around a mesh, in the coordinates of its file.
struct FileBox {
  Vec3<double> low, high;

  Vec3<double> size() const { return high - low; }
  double largest() const;
};

/// @pre the mesh has vertices
FileBox box_of(const Mesh& mesh);

/// A value of a scene, and why it was chosen.
struct Guess {
  std::string value;
  std::string reason;  ///< one line, for a comment
};

/// Value of "units". Cloth and bodies of people are 0.1 to 10 m large. Files of both come from one
/// program, so the body, whose size is better known, tells the unit of the cloth too.
Guess guess_units(const FileBox& cloth, const std::optional<FileBox>& body);

/// Value of "up". A body that stands says it; else cloth that starts above a body; else cloth that
/// lies flat; else what programs usually write in this format.
/// @param extension of the cloth's file, with its dot
Guess guess_up(const FileBox& cloth, const std::optional<FileBox>& body,
               const std::string& extension);

}  // namespace weft::app
