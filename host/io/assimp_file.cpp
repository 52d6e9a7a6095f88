#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <assimp/Importer.hpp>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <unordered_map>

#include "host/io/file_bytes.hpp"
#include "host/io/mesh_formats.hpp"
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
      : file_(file), with_material_(uv == Uv::material && with_material) {}

  void add(const aiMesh& source) {
    if (!(source.mPrimitiveTypes & aiPrimitiveType_TRIANGLE)) return;
    std::vector<Index> numbers;
    numbers.reserve(source.mNumVertices);
    for (unsigned v = 0; v < source.mNumVertices; ++v) numbers.push_back(vertex(source, v));
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
    }
  }

  Mesh mesh;

 private:
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
    if (with_material_) note_material(source, v, entry->second, is_new);
    return entry->second;
  }

  void note_material(const aiMesh& source, unsigned v, Index number, bool is_new) {
    const aiVector3D& t = source.mTextureCoords[0][v];
    const Vec2<double> u{static_cast<double>(t.x), static_cast<double>(t.y)};
    if (!std::isfinite(u[0]) || !std::isfinite(u[1]))
      throw SceneError(file_, "texture coordinate " + std::to_string(v), "nan or inf",
                       "finite numbers");
    if (is_new) mesh.material.push_back(u);
    if (!(mesh.material[static_cast<std::size_t>(number)] == u))
      throw SceneError(file_, "vertex " + std::to_string(v), "several texture coordinates",
                       "one texture coordinate a vertex; uv seams are not supported");
  }

  const std::string& file_;
  bool with_material_;
  std::unordered_map<Vec3<double>, Index, PositionHash> numbers_;
};

}  // namespace

Mesh read_with_assimp(const std::filesystem::path& path, Uv uv) {
  const std::string file = path.string();
  // For the message if the file is missing or no regular file; assimp has none worth showing.
  (void)read_file_bytes(path);
  Assimp::Importer importer;
  if (path.extension().empty() || !importer.IsExtensionSupported(path.extension().string()))
    throw SceneError(file, "format", "\"" + path.extension().string() + "\"",
                     ".obj, .ply and what assimp reads, such as .stl, .glb, .dae, .fbx");
  const aiScene* scene = importer.ReadFile(
      file, aiProcess_Triangulate | aiProcess_PreTransformVertices | aiProcess_SortByPType);
  if (!scene || !scene->HasMeshes()) {
    std::string reason = importer.GetErrorString();
    for (char& c : reason)
      if (c < ' ' || c > '~') c = ' ';
    throw SceneError(file + ": cannot read as a mesh: " + (reason.empty() ? "no mesh" : reason));
  }
  bool with_material = true;
  std::size_t vertices = 0;
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
    with_material = with_material && scene->mMeshes[m]->HasTextureCoords(0);
    vertices += scene->mMeshes[m]->mNumVertices;
  }
  if (vertices > static_cast<std::size_t>(std::numeric_limits<Index>::max()) / 3)
    throw SceneError(file, "vertices", std::to_string(vertices), "up to 715827882");
  Gatherer gatherer(file, uv, with_material);
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) gatherer.add(*scene->mMeshes[m]);
  if (gatherer.mesh.triangles.empty())
    throw SceneError(file, "faces", "no triangles", "at least one");
  return std::move(gatherer.mesh);
}

}  // namespace weft::io
