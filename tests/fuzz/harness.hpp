#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "weft/error.hpp"
#include "weft/scene.hpp"

/// What the targets share.
namespace weft::fuzz {

/// The folder in which inputs become files: this process's own, below the system's folder for
/// temporary files, removed at the end. The folder above it is private too.
const std::filesystem::path& folder();

/// Writes a file into folder(), in place of one that is there.
/// @return its path
std::filesystem::path put(const std::string& name, std::string_view bytes);

/// Makes folder() the working directory while it lives: readers look for files there too.
class Inside {
 public:
  Inside();
  ~Inside();
  Inside(const Inside&) = delete;
  Inside& operator=(const Inside&) = delete;

 private:
  std::filesystem::path before_;
};

/// @throws std::logic_error that says `what` unless `good`
void require(bool good, const std::string& what);

/// @throws std::logic_error unless the message is one line of characters that can be printed
void require_message(const SceneError& error);

/// What `read` returns, or nothing if it threw a SceneError, which must have a proper message.
template <class Read>
auto accepted(Read&& read) -> std::optional<decltype(read())> {
  try {
    return read();
  } catch (const SceneError& error) {
    require_message(error);
    return {};
  }
}

/// @throws std::logic_error unless the mesh is as read_mesh() promises: finite, in range, not empty
void require_whole(const Mesh& mesh);

/// Whether two meshes have the same points, triangles and material coordinates; groups may differ.
bool same_mesh(const Mesh& a, const Mesh& b);

/// FNV-1a, 64 bits, as spools and checkpoints have it.
std::uint64_t checksum_of(std::string_view bytes);

/// A square of two triangles as OBJ, with texture coordinates and a label at each vertex, to stand
/// beside inputs that need a mesh.
extern const std::string_view square_obj;

}  // namespace weft::fuzz
