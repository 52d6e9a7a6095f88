#include "host/io/usd/surface_file.hpp"

#include <cstddef>
#include <map>

namespace weft::io {
namespace {

/// Labels of the triangles of several meshes under common numbers.
class Labels {
 public:
  /// @param fallback names all triangles of a mesh that has no labels
  void add(const std::vector<Index>& own, const std::vector<std::string>& names,
           const std::string& fallback, std::size_t triangles) {
    if (own.empty()) {
      labels_.insert(labels_.end(), triangles, number_of(fallback));
      return;
    }
    says_something_ = true;
    for (const Index label : own)
      labels_.push_back(number_of(names[static_cast<std::size_t>(label)]));
  }
  /// Hands them over if they tell triangles apart.
  void take(std::vector<Index>& labels, std::vector<std::string>& names) {
    if (!says_something_ && names_.size() < 2) return;
    labels = std::move(labels_);
    names = std::move(names_);
  }

 private:
  Index number_of(const std::string& name) {
    const auto [entry, fresh] = numbers_.emplace(name, static_cast<Index>(names_.size()));
    if (fresh) names_.push_back(name);
    return entry->second;
  }

  std::vector<Index> labels_;
  std::vector<std::string> names_;
  std::map<std::string, Index> numbers_;
  bool says_something_ = false;
};

}  // namespace

Mesh surface_at(const UsdFile& file, double time, Uv uv) {
  std::vector<NamedMesh> meshes;
  Labels groups, parts;
  for (std::size_t m = 0; m < file.meshes().size(); ++m) {
    const std::string& name = file.meshes()[m].name;
    Mesh mesh = file.read(m, time, uv);
    move_origin(mesh, file.origin(m), {0, 0, 0});
    groups.add(mesh.group, mesh.group_names, name, mesh.triangles.size());
    parts.add(mesh.part, mesh.part_names, name, mesh.triangles.size());
    meshes.push_back({name, std::move(mesh)});
  }
  Mesh surface = joined(meshes);
  groups.take(surface.group, surface.group_names);
  parts.take(surface.part, surface.part_names);
  return surface;
}

bool is_usd_file(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return extension == ".usda";
}

Mesh read_surface(const std::filesystem::path& path, Uv uv, const ReadableFolders& folders,
                  std::vector<std::string>* warnings) {
  if (!is_usd_file(path)) return read_mesh(path, uv, folders, warnings);
  const UsdFile file(path);
  if (warnings != nullptr && file.has_skeleton())
    warnings->push_back(path.string() +
                        ": its skeleton is passed over: the mesh stands as its "
                        "points are");
  if (warnings != nullptr && file.times().size() > 1)
    warnings->push_back(path.string() + ": only the first of its " +
                        std::to_string(file.times().size()) +
                        " time codes is taken; an obstacle can move with \"sequence\"");
  return surface_at(file, file.times().front(), uv);
}

}  // namespace weft::io
