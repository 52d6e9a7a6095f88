#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <tuple>
#include <unordered_map>

#include "host/input/safe_text.hpp"
#include "host/io/mesh/assimp_import.hpp"
#include "host/io/mesh/mesh_formats.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

struct PositionHash {
  std::size_t operator()(const Vec3<double>& x) const {
    std::uint64_t hash = 0;
    for (int k = 0; k < 3; ++k)  // adding 0 makes -0 and 0, which are equal, hash alike
      hash = (hash ^ std::bit_cast<std::uint64_t>(x[k] + 0.0)) * 0x9e3779b97f4a7c15u + (hash >> 29);
    return hash;
  }
};

/// Gathers assimp's meshes into one, joining vertices at equal positions: assimp and many formats
/// store a vertex once a corner or once a normal.
class Gatherer {
 public:
  Gatherer(const std::string& file, Uv uv, bool with_material)
      : file_(file), with_material_(uv != Uv::ignore && with_material) {}

  /// @param group name of these faces
  void add(const aiMesh& source, const std::string& group) {
    if (!(source.mPrimitiveTypes & aiPrimitiveType_TRIANGLE)) return;
    std::vector<Index> numbers;
    std::vector<Index> pairs;
    numbers.reserve(source.mNumVertices);
    for (unsigned v = 0; v < source.mNumVertices; ++v) {
      numbers.push_back(vertex(source, v));
      if (with_material_) pairs.push_back(material_pair(source, v, numbers.back()));
    }
    const Index group_number = number_of(group);
    for (unsigned f = 0; f < source.mNumFaces; ++f) {
      const aiFace& face = source.mFaces[f];
      if (face.mNumIndices != 3) continue;
      Tri tri{};
      for (unsigned k = 0; k < 3; ++k) {
        if (face.mIndices[k] >= numbers.size())
          throw SceneError(file_, "face " + std::to_string(f),
                           "vertex " + std::to_string(face.mIndices[k]), "a vertex of the mesh");
        tri.v[k] = numbers[face.mIndices[k]];
      }
      mesh.triangles.push_back(tri);
      mesh.group.push_back(group_number);
      if (!with_material_) continue;
      Tri corners{};
      for (unsigned k = 0; k < 3; ++k) corners.v[k] = pairs[face.mIndices[k]];
      mesh.material_triangles.push_back(corners);
    }
  }

  /// Drops corners in material space that say no more than the triangles do.
  Mesh take() {
    if (mesh.material.size() == mesh.positions.size()) mesh.material_triangles.clear();
    return std::move(mesh);
  }

  Mesh mesh;

 private:
  /// Of a position, whatever its number in the file.
  Index vertex(const aiMesh& source, unsigned v) {
    const aiVector3D& p = source.mVertices[v];
    const Vec3<double> x{static_cast<double>(p.x), static_cast<double>(p.y),
                         static_cast<double>(p.z)};
    for (int k = 0; k < 3; ++k)
      if (!std::isfinite(x[k]))
        throw SceneError(file_, "vertex " + std::to_string(v), std::isnan(x[k]) ? "nan" : "inf",
                         "finite numbers");
    const auto [entry, is_new] = numbers_.try_emplace(x, static_cast<Index>(mesh.positions.size()));
    if (is_new) mesh.positions.push_back(x);
    return entry->second;
  }

  /// Number of the material coordinates of a corner; the first pair of vertex n is pair n as long
  /// as no vertex has two.
  Index material_pair(const aiMesh& source, unsigned v, Index number) {
    const aiVector3D& t = source.mTextureCoords[0][v];
    const Vec2<double> u{static_cast<double>(t.x), static_cast<double>(t.y)};
    if (!std::isfinite(u[0]) || !std::isfinite(u[1]))
      throw SceneError(file_, "texture coordinate " + std::to_string(v), "nan or inf",
                       "finite numbers");
    const auto [entry, is_new] = pairs_.try_emplace(std::tuple(number, u[0], u[1]),
                                                    static_cast<Index>(mesh.material.size()));
    if (is_new) mesh.material.push_back(u);
    return entry->second;
  }

  Index number_of(const std::string& group) {
    const auto found = std::find(mesh.group_names.begin(), mesh.group_names.end(), group);
    const auto number = static_cast<Index>(found - mesh.group_names.begin());
    if (found == mesh.group_names.end()) mesh.group_names.push_back(group);
    return number;
  }

  const std::string& file_;
  bool with_material_;
  std::unordered_map<Vec3<double>, Index, PositionHash> numbers_;
  std::map<std::tuple<Index, double, double>, Index> pairs_;  ///< by vertex and coordinates
};

/// Name of the material, or else of the mesh.
std::string group_name(const aiScene& scene, unsigned m) {
  const aiMesh& mesh = *scene.mMeshes[m];
  aiString name;
  if (mesh.mMaterialIndex < scene.mNumMaterials &&
      scene.mMaterials[mesh.mMaterialIndex]->Get(AI_MATKEY_NAME, name) == aiReturn_SUCCESS &&
      name.length > 0 && std::string(name.C_Str()) != AI_DEFAULT_MATERIAL_NAME)
    return name.C_Str();
  return mesh.mName.C_Str();
}

}  // namespace

Mesh read_with_assimp(const std::filesystem::path& path, Uv uv, const ReadableFolders& folders) {
  const std::string file = path.string();
  Assimp::Importer importer;
  const aiScene* scene = &import_with_assimp(
      importer, path,
      aiProcess_Triangulate | aiProcess_PreTransformVertices | aiProcess_SortByPType, folders,
      "a mesh", ".obj, .ply and what assimp reads, such as .stl, .glb, .dae, .fbx");
  bool with_material = true;
  std::size_t vertices = 0;
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
    with_material = with_material && scene->mMeshes[m]->HasTextureCoords(0);
    vertices += scene->mMeshes[m]->mNumVertices;
  }
  if (vertices > static_cast<std::size_t>(std::numeric_limits<Index>::max()) / 3)
    throw SceneError(file, "vertices", std::to_string(vertices), "up to 715827882");
  Gatherer gatherer(file, uv, with_material);
  for (unsigned m = 0; m < scene->mNumMeshes; ++m)
    gatherer.add(*scene->mMeshes[m], one_line(group_name(*scene, m)));
  if (gatherer.mesh.triangles.empty())
    throw SceneError(file, "faces", "no triangles", "at least one");
  return gatherer.take();
}

}  // namespace weft::io
