#include "tests/fuzz/harness.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <fstream>
#include <stdexcept>
#include <system_error>

#include "host/base/scratch_folder.hpp"

namespace weft::fuzz {
namespace {

namespace fs = std::filesystem;

void require_corners(const std::vector<Tri>& triangles, std::size_t count) {
  for (const Tri& t : triangles)
    for (const Index v : t.v)
      require(v >= 0 && static_cast<std::size_t>(v) < count, "a corner out of range");
}

bool same_triangles(const std::vector<Tri>& a, const std::vector<Tri>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const Tri& s, const Tri& t) { return std::equal(s.v, s.v + 3, t.v); });
}

}  // namespace

const std::string_view square_obj =
    "v 0 0 0\nnl 1\nv 1 0 0\nnl 2\nv 1 1 0\nnl 1\nv 0 1 0\nnl 2\n"
    "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n";

const fs::path& folder() {
  static const ScratchFolder own;
  // One further down, so that `..` in an input stays within it.
  static const fs::path inner = [] {
    fs::create_directory(own / "inner");
    return own / "inner";
  }();
  return inner;
}

fs::path put(const std::string& name, std::string_view bytes) {
  const fs::path path = folder() / name;
  std::ofstream stream(path, std::ios::binary);
  stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  stream.close();
  require(stream.good(), "the input could not be written");
  return path;
}

Inside::Inside() : before_(fs::current_path()) {
  fs::current_path(folder());
}
Inside::~Inside() {
  std::error_code error;
  fs::current_path(before_, error);
}

void require(bool good, const std::string& what) {
  if (!good) throw std::logic_error(what);
}

void require_message(const SceneError& error) {
  const std::string_view text = error.what();
  require(!text.empty(), "an empty message");
  for (const char c : text)
    require(static_cast<unsigned char>(c) >= ' ' && c != '\x7f',
            "a message with control characters: " + std::string(text));
}

void require_whole(const Mesh& mesh) {
  require(!mesh.positions.empty() && !mesh.triangles.empty(), "a mesh without content");
  for (const Vec3<double>& x : mesh.positions)
    for (int k = 0; k < 3; ++k) require(std::isfinite(x[k]), "a position that is not finite");
  for (const Vec2<double>& u : mesh.material)
    for (int k = 0; k < 2; ++k)
      require(std::isfinite(u[k]), "a material coordinate that is not finite");
  require_corners(mesh.triangles, mesh.positions.size());
  require_corners(mesh.material_triangles, mesh.material.size());
  const std::size_t triangles = mesh.triangles.size();
  if (mesh.material_triangles.empty())
    require(mesh.material.empty() || mesh.material.size() == mesh.positions.size(),
            "material coordinates for some vertices only");
  else
    require(mesh.material_triangles.size() == triangles, "material corners of some triangles only");
  require(mesh.group.empty() || mesh.group.size() == triangles, "groups of some triangles only");
  for (const std::string& name : mesh.group_names)
    for (const char c : name)
      require(static_cast<unsigned char>(c) >= ' ' && c != '\x7f',
              "a group's name with control characters");
  for (const Index group : mesh.group)
    require(group >= 0 && static_cast<std::size_t>(group) < mesh.group_names.size(),
            "a group out of range");
}

bool same_mesh(const Mesh& a, const Mesh& b) {
  return a.positions == b.positions && a.material == b.material &&
         same_triangles(a.triangles, b.triangles) &&
         same_triangles(a.material_triangles, b.material_triangles);
}

std::uint64_t checksum_of(std::string_view bytes) {
  std::uint64_t hash = 14695981039346656037u;
  for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211u;
  return hash;
}

}  // namespace weft::fuzz
