#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "host/io/mesh/mesh_file.hpp"

/// Objects and panels of faces in PLY. The format has no names, so comments of the header give
/// them by number, and faces have the properties `object` and `panel`:
///   comment object 0 shirt
///   comment panel 0 left_front
///   comment label 0 leg
/// A face of no panel has the panel -1.
namespace weft::io {

/// Reads them.
class PlyFaceLabels {
 public:
  struct Face {
    long long object = 0;
    long long panel = -1;
  };

  /// @param words of the line, with "comment"
  void read_comment(const std::vector<std::string_view>& words, std::string_view line);
  /// A number of a face. Other properties are passed over.
  static void take(const std::string& property, double value, Face& face);
  void add_triangle(const Face& face);
  /// Groups are panels, or else objects; objects are kept beside panels, see Mesh. Nothing changes
  /// if the header has no names.
  void hand_over(Mesh& mesh);

 private:
  std::map<long long, std::string> objects_, panels_, labels_;  ///< by number
  std::vector<Face> faces_;                                     ///< [triangles]
};

/// Writes them.
class PlyPanels {
 public:
  /// @param meshes kept by reference
  explicit PlyPanels(const std::vector<NamedMesh>& meshes);

  std::string comments() const;    ///< of the header
  std::string properties() const;  ///< of the element face
  void append_row(std::string& bytes, std::size_t mesh, std::size_t triangle) const;

 private:
  const std::vector<NamedMesh>& meshes_;
  bool with_objects_ = false;        ///< faces say which mesh they are of
  bool with_panels_ = false;         ///< some mesh has_panels()
  std::vector<std::int32_t> first_;  ///< [meshes] number of its first panel
};

}  // namespace weft::io
