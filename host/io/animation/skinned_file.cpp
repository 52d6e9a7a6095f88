#include "host/io/animation/skinned_file.hpp"

#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "host/geometry/manifold_mesh.hpp"
#include "host/input/safe_text.hpp"
#include "host/io/mesh/assimp_import.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

Vec3<double> vector_of(const aiVector3D& v) {
  return {static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)};
}

Quaternion quaternion_of(const aiQuaternion& q) {
  return normalized(
      {static_cast<double>(q.w),
       {static_cast<double>(q.x), static_cast<double>(q.y), static_cast<double>(q.z)}});
}

/// The last row, which is 0 0 0 1 in every format that has one, is left out.
Affine affine_of(const aiMatrix4x4& m) {
  Affine a;
  for (unsigned r = 0; r < 3; ++r) {
    for (unsigned c = 0; c < 3; ++c)
      a.linear(static_cast<int>(r), static_cast<int>(c)) = static_cast<double>(m[r][c]);
    a.translate[static_cast<int>(r)] = static_cast<double>(m[r][3]);
  }
  return a;
}

bool is_finite(const Vec3<double>& x) {
  return std::isfinite(x[0]) && std::isfinite(x[1]) && std::isfinite(x[2]);
}

bool is_finite(const Affine& a) {
  for (const double x : a.linear.e)
    if (!std::isfinite(x)) return false;
  return is_finite(a.translate);
}

/// Keys of one kind in increasing time; of several at one time the last counts.
template <class Value, class Key, class Convert>
Track<Value> track_of(const Key* keys, unsigned count, double ticks_per_second,
                      const Convert& convert, const std::string& file, const std::string& node) {
  std::vector<std::pair<double, Value>> all;
  all.reserve(count);
  for (unsigned k = 0; k < count; ++k) {
    const double time = keys[k].mTime / ticks_per_second;
    if (!std::isfinite(time))
      throw SceneError(file, "animation of node " + node, "a time that is not finite",
                       "finite numbers");
    all.emplace_back(time, convert(keys[k].mValue));
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  Track<Value> track;
  for (const auto& key : all)
    if (!track.empty() && track.back().first == key.first)
      track.back() = key;
    else
      track.push_back(key);
  return track;
}

/// Takes assimp's scene over into a skin.
class SkinReader {
 public:
  SkinReader(const aiScene& scene, const std::string& file, std::vector<std::string>& warnings)
      : scene_(scene), file_(file), warnings_(warnings) {
    surface_.skin.first_influence.push_back(0);
  }

  SkinnedSurface read(const SkinnedChoice& choice) {
    add_nodes();
    animate(chosen(choice));
    for (std::size_t n = 0; n < sources_.size(); ++n)
      for (unsigned m = 0; m < sources_[n]->mNumMeshes; ++m)
        add_mesh(sources_[n]->mMeshes[m], static_cast<Index>(n));
    if (surface_.triangles.empty())
      throw SceneError(file_, "faces", "no triangles", "at least one");
    surface_.skin.to_world = axes_to_world(choice.y_up, choice.scale);
    return std::move(surface_);
  }

 private:
  void add_nodes() {
    std::vector<std::pair<const aiNode*, Index>> open{{scene_.mRootNode, -1}};
    while (!open.empty()) {
      const auto [source, parent] = open.back();
      open.pop_back();
      const auto number = static_cast<Index>(sources_.size());
      SkeletonNode node;
      node.name = source->mName.C_Str();
      node.parent = parent;
      node.local = affine_of(source->mTransformation);
      if (!is_finite(node.local))
        throw SceneError(file_, "transform of node " + quoted_start(node.name), "nan or inf",
                         "finite numbers");
      node_of_.try_emplace(node.name, number);
      surface_.skin.nodes.push_back(std::move(node));
      sources_.push_back(source);
      for (unsigned c = source->mNumChildren; c > 0; --c)
        open.emplace_back(source->mChildren[c - 1], number);
    }
  }

  const aiAnimation& chosen(const SkinnedChoice& choice) const {
    if (scene_.mNumAnimations == 0)
      throw SceneError(file_, "animation", "none in the file",
                       "a file with an animation; \"mesh\" reads one without");
    std::string list;
    for (unsigned a = 0; a < scene_.mNumAnimations; ++a) {
      const aiAnimation& animation = *scene_.mAnimations[a];
      if (choice.name ? *choice.name == animation.mName.C_Str()
                      : std::cmp_equal(choice.animation, a))
        return animation;
      if (a < 10) list += (a > 0 ? ", " : "") + quoted_start(animation.mName.C_Str());
    }
    throw SceneError(
        file_, "animation",
        choice.name ? quoted_start(*choice.name) : std::to_string(choice.animation),
        "a number from 0 to " + std::to_string(scene_.mNumAnimations - 1) + ", or a name: " + list);
  }

  void animate(const aiAnimation& animation) {
    if (animation.mNumMorphMeshChannels > 0 || animation.mNumMeshChannels > 0)
      throw SceneError(file_, "animation " + quoted_start(animation.mName.C_Str()),
                       "morph targets (shape keys)",
                       "animations of nodes and bones; export the shapes as a sequence of meshes");
    const double ticks = animation.mTicksPerSecond > 0 && std::isfinite(animation.mTicksPerSecond)
                             ? animation.mTicksPerSecond
                             : 25;  // what assimp's own viewer takes for "not given"
    double start = 0;
    double end =
        std::isfinite(animation.mDuration) ? std::max(animation.mDuration / ticks, 0.0) : 0;
    for (unsigned c = 0; c < animation.mNumChannels; ++c) {
      const aiNodeAnim& channel = *animation.mChannels[c];
      const auto found = node_of_.find(channel.mNodeName.C_Str());
      if (found == node_of_.end()) {
        warnings_.push_back(file_ + ": animation of " + quoted_start(channel.mNodeName.C_Str()) +
                            ", a node that is not there, left out");
        continue;
      }
      SkeletonNode& node = surface_.skin.nodes[static_cast<std::size_t>(found->second)];
      set_tracks(channel, ticks, node);
      for (const auto& [first, last] :
           {std::pair{node.translate.front().first, node.translate.back().first},
            std::pair{node.rotate.front().first, node.rotate.back().first},
            std::pair{node.scale.front().first, node.scale.back().first}}) {
        start = std::min(start, first);
        end = std::max(end, last);
      }
    }
    surface_.skin.clip_start = start;
    surface_.skin.duration = end - start;
  }

  void set_tracks(const aiNodeAnim& channel, double ticks, SkeletonNode& node) const {
    const std::string name = quoted_start(node.name);
    node.animated = true;
    node.translate = track_of<Vec3<double>>(channel.mPositionKeys, channel.mNumPositionKeys, ticks,
                                            vector_of, file_, name);
    node.rotate = track_of<Quaternion>(channel.mRotationKeys, channel.mNumRotationKeys, ticks,
                                       quaternion_of, file_, name);
    node.scale = track_of<Vec3<double>>(channel.mScalingKeys, channel.mNumScalingKeys, ticks,
                                        vector_of, file_, name);
    const auto finite = [](const auto& key) { return is_finite(key.second); };
    if (!std::all_of(node.translate.begin(), node.translate.end(), finite) ||
        !std::all_of(node.scale.begin(), node.scale.end(), finite))
      throw SceneError(file_, "animation of node " + name, "nan or inf", "finite numbers");
    // What has no keys stays as it is in the file.
    const aiNode* source = sources_[static_cast<std::size_t>(node_of_.at(node.name))];
    aiVector3D scale;
    aiVector3D position;
    aiQuaternion rotation;
    source->mTransformation.Decompose(scale, rotation, position);
    if (node.translate.empty()) node.translate.emplace_back(0, vector_of(position));
    if (node.rotate.empty()) node.rotate.emplace_back(0, quaternion_of(rotation));
    if (node.scale.empty()) node.scale.emplace_back(0, vector_of(scale));
  }

  Index bone(Index node, const Affine& offset) {
    auto& bones = surface_.skin.bones;
    std::vector<Index>& of_node = bones_of_[node];
    for (const Index b : of_node) {
      const Affine& other = bones[static_cast<std::size_t>(b)].offset;
      if (other.translate == offset.translate &&
          std::equal(std::begin(offset.linear.e), std::end(offset.linear.e),
                     std::begin(other.linear.e)))
        return b;
    }
    of_node.push_back(static_cast<Index>(bones.size()));
    bones.push_back({node, offset});
    return of_node.back();
  }

  /// Influences of each vertex of a mesh, by bone, with a sum of 1.
  std::vector<std::vector<Influence>> weights_of(const aiMesh& mesh, Index node) {
    std::vector<std::vector<Influence>> weights(mesh.mNumVertices);
    for (unsigned b = 0; b < mesh.mNumBones; ++b) {
      const aiBone& source = *mesh.mBones[b];
      const auto found = node_of_.find(source.mName.C_Str());
      const Affine offset = affine_of(source.mOffsetMatrix);
      if (!is_finite(offset))
        throw SceneError(file_, "bone " + quoted_start(source.mName.C_Str()), "nan or inf",
                         "finite numbers");
      // Such a bone can move nothing; its vertices stay with their mesh.
      if (found == node_of_.end())
        warnings_.push_back(file_ + ": bone " + quoted_start(source.mName.C_Str()) +
                            ", of which there is no node, left out");
      const Index number = found == node_of_.end() ? bone(node, {}) : bone(found->second, offset);
      for (unsigned w = 0; w < source.mNumWeights; ++w) {
        const auto v = source.mWeights[w].mVertexId;
        const auto weight = static_cast<double>(source.mWeights[w].mWeight);
        if (v >= mesh.mNumVertices || !std::isfinite(weight))
          throw SceneError(file_, "weight of bone " + quoted_start(source.mName.C_Str()),
                           v >= mesh.mNumVertices ? "vertex " + std::to_string(v) : "nan or inf",
                           "finite weights of vertices of the mesh");
        if (weight > 0) weights[v].push_back({number, weight});
      }
    }
    Index own = -1;
    for (auto& list : weights) {
      if (list.empty()) {
        if (own < 0) own = bone(node, {});
        list.push_back({own, 1});
      }
      std::stable_sort(list.begin(), list.end(),
                       [](const Influence& a, const Influence& b) { return a.bone < b.bone; });
      double sum = 0;
      for (const Influence& i : list) sum += i.weight;
      for (Influence& i : list) i.weight /= sum;
    }
    return weights;
  }

  void add_mesh(unsigned number, Index node) {
    if (number >= scene_.mNumMeshes)
      throw SceneError(file_, "node", "mesh " + std::to_string(number), "a mesh of the file");
    const aiMesh& mesh = *scene_.mMeshes[number];
    if (!(mesh.mPrimitiveTypes & aiPrimitiveType_TRIANGLE)) return;
    // A mesh with bones stands where they are, whichever nodes name it.
    if (mesh.mNumBones > 0 && !drawn_.insert(number).second) return;
    for (unsigned a = 0; a < mesh.mNumAnimMeshes; ++a)
      if (mesh.mAnimMeshes[a]->mWeight != 0)
        warnings_.push_back(file_ + ": morph target " +
                            quoted_start(mesh.mAnimMeshes[a]->mName.C_Str()) + " left out");
    if (surface_.skin.rest.size() + mesh.mNumVertices >
        static_cast<std::size_t>(std::numeric_limits<Index>::max()) / 3)
      throw SceneError(file_, "vertices", "too many", "up to 715827882");
    const std::vector<std::vector<Influence>> weights = weights_of(mesh, node);
    std::vector<Index> numbers;
    numbers.reserve(mesh.mNumVertices);
    for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
      const Vec3<double> x = vector_of(mesh.mVertices[v]);
      if (!is_finite(x))
        throw SceneError(file_, "vertex " + std::to_string(v), "nan or inf", "finite numbers");
      numbers.push_back(vertex(x, weights[v]));
    }
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      if (face.mNumIndices != 3) continue;
      Tri tri{};
      for (unsigned k = 0; k < 3; ++k) {
        if (face.mIndices[k] >= numbers.size())
          throw SceneError(file_, "face " + std::to_string(f),
                           "vertex " + std::to_string(face.mIndices[k]), "a vertex of the mesh");
        tri.v[k] = numbers[face.mIndices[k]];
      }
      surface_.triangles.push_back(tri);
    }
  }

  /// Number of the vertex with this position and these influences.
  Index vertex(const Vec3<double>& x, const std::vector<Influence>& influences) {
    Skin& skin = surface_.skin;
    std::uint64_t hash = 0;
    const auto stir = [&](std::uint64_t bits) {
      hash = (hash ^ bits) * 0x9e3779b97f4a7c15u;
      hash ^= hash >> 29;
    };
    // Adding 0 makes -0 and 0, which are equal, hash alike.
    for (int k = 0; k < 3; ++k) stir(std::bit_cast<std::uint64_t>(x[k] + 0.0));
    for (const Influence& i : influences) stir(static_cast<std::uint64_t>(i.bone));
    const auto [first, last] = numbers_.equal_range(hash);
    for (auto entry = first; entry != last; ++entry)
      if (is_vertex(static_cast<std::size_t>(entry->second), x, influences)) return entry->second;
    const auto number = static_cast<Index>(skin.rest.size());
    numbers_.emplace(hash, number);
    skin.rest.push_back(x);
    skin.influences.insert(skin.influences.end(), influences.begin(), influences.end());
    skin.first_influence.push_back(static_cast<Offset>(skin.influences.size()));
    return number;
  }

  bool is_vertex(std::size_t v, const Vec3<double>& x,
                 const std::vector<Influence>& influences) const {
    const Skin& skin = surface_.skin;
    const auto first = skin.influences.begin() + skin.first_influence[v];
    const auto last = skin.influences.begin() + skin.first_influence[v + 1];
    return skin.rest[v] == x && std::equal(first, last, influences.begin(), influences.end(),
                                           [](const Influence& a, const Influence& b) {
                                             return a.bone == b.bone && a.weight == b.weight;
                                           });
  }

  const aiScene& scene_;
  const std::string& file_;
  std::vector<std::string>& warnings_;
  SkinnedSurface surface_;
  std::vector<const aiNode*> sources_;  ///< [nodes]
  std::unordered_map<std::string, Index> node_of_;
  std::unordered_map<Index, std::vector<Index>> bones_of_;
  std::unordered_multimap<std::uint64_t, Index> numbers_;
  std::unordered_set<unsigned> drawn_;  ///< meshes with bones
};

/// Brings the surface into a form that check_mesh() accepts at the start of the clip.
void repair(SkinnedSurface& surface, const std::string& file, std::vector<std::string>& warnings) {
  std::vector<Vec3<double>> start(surface.skin.rest.size());
  SkinnedDeformation at_start(surface.skin, {});
  at_start.positions(0, start);
  if (!std::all_of(start.begin(), start.end(), [](const auto& x) { return is_finite(x); }))
    throw SceneError(file, "animation", "positions that overflow", "finite numbers");
  const ManifoldMesh manifold = make_manifold(start, surface.triangles);
  if (manifold.triangles.empty())
    throw SceneError(file, "faces", "no triangle with an area", "at least one");
  if (manifold.dropped > 0)
    warnings.push_back(file + ": " + std::to_string(manifold.dropped) +
                       " triangles without area, or there twice, left out");
  if (manifold.detached > 0)
    warnings.push_back(file + ": " + std::to_string(manifold.detached) +
                       " triangles detached where more than two, or two of opposite orientation, "
                       "share an edge");
  const Skin& old = at_start.skin();
  Skin& skin = surface.skin;
  skin.rest.clear();
  skin.influences.clear();
  skin.first_influence.assign(1, 0);
  for (const Index source : manifold.source) {
    const auto v = static_cast<std::size_t>(source);
    skin.rest.push_back(old.rest[v]);
    skin.influences.insert(skin.influences.end(), old.influences.begin() + old.first_influence[v],
                           old.influences.begin() + old.first_influence[v + 1]);
    skin.first_influence.push_back(static_cast<Offset>(skin.influences.size()));
  }
  surface.triangles = manifold.triangles;
}

}  // namespace

SkinnedSurface read_skinned(const std::filesystem::path& path, const SkinnedChoice& choice,
                            std::vector<std::string>& warnings, const ReadableFolders& folders) {
  const std::string file = path.string();
  Assimp::Importer importer;
  const aiScene* scene = &import_with_assimp(
      importer, path, aiProcess_Triangulate | aiProcess_SortByPType, folders, "an animated mesh",
      "what assimp reads, such as .fbx, .gltf, .glb, .dae, .x");
  SkinnedSurface surface = SkinReader(*scene, file, warnings).read(choice);
  repair(surface, file, warnings);
  return surface;
}

}  // namespace weft::io
