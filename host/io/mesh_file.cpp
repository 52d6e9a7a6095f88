#include "host/io/mesh_file.hpp"

#include <algorithm>
#include <charconv>
#include <system_error>

#include "host/io/file_bytes.hpp"
#include "host/io/mesh_formats.hpp"
#include "host/scene/atomic_file.hpp"

namespace weft::io {
namespace {

std::string lower_extension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return extension;
}

template <class Number>
bool parse_whole(std::string_view token, Number& value) {
  if (token.size() > 1 && token[0] == '+' && token[1] != '-') token.remove_prefix(1);
  const char* end = token.data() + token.size();
  const auto [stop, error] = std::from_chars(token.data(), end, value);
  return error == std::errc() && stop == end;
}

}  // namespace

bool parse_number(std::string_view token, double& value) {
  return parse_whole(token, value);
}
bool parse_number(std::string_view token, long long& value) {
  return parse_whole(token, value);
}

Mesh read_mesh(const std::filesystem::path& path, Uv uv) {
  const std::string extension = lower_extension(path);
  if (extension == ".obj") return parse_obj(read_file_bytes(path), path.string(), uv);
  if (extension == ".ply") return parse_ply(read_file_bytes(path), path.string(), uv);
  return read_with_assimp(path, uv);
}

void write_obj(const std::filesystem::path& path, const std::vector<NamedMesh>& meshes) {
  write_file_atomically(path, format_obj(meshes), Durability::none);
}

void write_ply(const std::filesystem::path& path, const std::vector<NamedMesh>& meshes,
               Precision precision) {
  write_file_atomically(path, format_ply(meshes, precision), Durability::none);
}

}  // namespace weft::io
