#include "host/io/gltf/glb_file.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/base/file_operations.hpp"
#include "host/base/temporary_file.hpp"
#include "host/geometry/similarity.hpp"
#include "host/geometry/vertex_normals.hpp"
#include "host/input/safe_text.hpp"
#include "host/io/spool/material_colour.hpp"
#include "host/scene/frame_limits.hpp"
#include "weft/error.hpp"
#include "weft/version.hpp"

namespace weft::io {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

static_assert(std::endian::native == std::endian::little);

constexpr int type_float = 5126;
constexpr int type_index = 5125;
constexpr int target_vertices = 34962;
constexpr int target_indices = 34963;

/// Share of the size of a mesh by which its points may miss a rigid motion: some roundings of
/// single precision.
constexpr double rigid_tolerance = 1e-6;

[[noreturn]] void fail(const fs::path& path) {
  throw SceneError(path.string() + ": cannot write");
}

/// The binary part of the file, on its way to a file of its own: the text part, which says how long
/// it is, comes first.
class Binary {
 public:
  Binary(const fs::path& target, const fs::path& path)
      : target_(target), stream_(path, std::ios::binary | std::ios::trunc) {}

  /// @param target what the values are for; 0: neither vertices nor indices
  /// @return the number of the accessor
  template <class T>
  std::size_t add(const std::vector<T>& values, int component, const char* type, int target = 0) {
    const std::size_t bytes = values.size() * sizeof(T);
    if (static_cast<double>(size_) + static_cast<double>(bytes) > max_glb_bytes)
      throw SceneError(target_.string(), "size", "more than 4 GiB",
                       "less: fewer frames (--frame), or the format usda");
    Json view{{"buffer", 0}, {"byteOffset", size_}, {"byteLength", bytes}};
    if (target != 0) view["target"] = target;
    views_.push_back(std::move(view));
    accessors_.push_back({{"bufferView", views_.size() - 1},
                          {"componentType", component},
                          {"count", values.size()},
                          {"type", type}});
    stream_.write(reinterpret_cast<const char*>(values.data()),
                  static_cast<std::streamsize>(bytes));
    size_ += bytes;  // a multiple of four
    return accessors_.size() - 1;
  }

  /// Vectors of vertices, with their bounds, which points must have.
  std::size_t add_vertices(const std::vector<Vec3<float>>& values) {
    const std::size_t accessor = add(values, type_float, "VEC3", target_vertices);
    Vec3<float> low = values.front(), high = low;
    for (const Vec3<float>& x : values)
      for (int k = 0; k < 3; ++k) {
        low[k] = std::min(low[k], x[k]);
        high[k] = std::max(high[k], x[k]);
      }
    accessors_[accessor]["min"] = {low[0], low[1], low[2]};
    accessors_[accessor]["max"] = {high[0], high[1], high[2]};
    return accessor;
  }

  /// Instants of keys, increasing.
  std::size_t add_times(const std::vector<float>& times) {
    const std::size_t accessor = add(times, type_float, "SCALAR");
    accessors_[accessor]["min"] = Json::array({times.front()});
    accessors_[accessor]["max"] = Json::array({times.back()});
    return accessor;
  }

  std::size_t size() const { return size_; }
  const Json& views() const { return views_; }
  const Json& accessors() const { return accessors_; }
  /// @return whether all of it was written
  bool close() {
    stream_.close();
    return stream_.good();
  }

 private:
  fs::path target_;
  std::ofstream stream_;
  std::size_t size_ = 0;
  Json views_ = Json::array();
  Json accessors_ = Json::array();
};

/// Vertices as glTF has them, with one texture coordinate each.
class Corners {
 public:
  explicit Corners(const Mesh& mesh) : vertex_count_(mesh.positions.size()) {
    if (mesh.material.empty()) return;
    coordinates_.assign(vertex_count_, Vec2<float>{0, 0});
    std::vector<Index> first(vertex_count_, -1);
    const bool seams = !mesh.material_triangles.empty();
    for (std::size_t v = 0; !seams && v < vertex_count_; ++v)
      coordinates_[v] = of_gltf(mesh.material[v]);
    if (!seams) return;
    triangles_ = mesh.triangles;
    std::map<std::pair<Index, Index>, Index> more;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      for (int k = 0; k < 3; ++k) {
        const Index vertex = mesh.triangles[t].v[k];
        const Index material = mesh.material_triangles[t].v[k];
        Index& own = first[static_cast<std::size_t>(vertex)];
        const Vec2<float> uv = of_gltf(mesh.material[static_cast<std::size_t>(material)]);
        if (own < 0) {
          own = material;
          coordinates_[static_cast<std::size_t>(vertex)] = uv;
        }
        if (own == material) continue;
        const auto [entry, fresh] =
            more.emplace(std::pair(vertex, material), static_cast<Index>(coordinates_.size()));
        if (fresh) {
          coordinates_.push_back(uv);
          repeated_.push_back(vertex);
        }
        triangles_[t].v[k] = entry->second;
      }
  }

  const std::vector<Tri>& triangles(const Mesh& mesh) const {
    return triangles_.empty() ? mesh.triangles : triangles_;
  }
  /// [vertices] empty: none
  const std::vector<Vec2<float>>& coordinates() const { return coordinates_; }

  template <class T>
  std::vector<T> with_repeated(std::vector<T> values) const {
    for (const Index vertex : repeated_) values.push_back(values[static_cast<std::size_t>(vertex)]);
    return values;
  }

 private:
  /// The second one runs downwards there.
  static Vec2<float> of_gltf(const Vec2<double>& uv) {
    return {static_cast<float>(uv[0]), static_cast<float>(1 - uv[1])};
  }

  std::size_t vertex_count_;
  std::vector<Vec2<float>> coordinates_;
  std::vector<Tri> triangles_;  ///< empty: those of the mesh
  std::vector<Index> repeated_;
};

std::vector<Vec3<float>> difference(std::vector<Vec3<float>> a, const std::vector<Vec3<float>>& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] -= b[i];
  return a;
}

/// Materials of the file, by name; "" stands for cloth and obstacles of which nothing is known.
class Materials {
 public:
  std::size_t number_of(const std::string& name, bool obstacle) {
    const auto [entry, fresh] = numbers_.emplace(std::pair(obstacle, name), list_.size());
    if (fresh) {
      const Vec3<double> colour =
          obstacle ? Vec3<double>{0.6, 0.6, 0.6} : material_colour(list_.size());
      const std::string shown = !name.empty() ? one_line(name) : obstacle ? "obstacle" : "cloth";
      list_.push_back({{"name", shown},
                       {"doubleSided", true},
                       {"pbrMetallicRoughness",
                        {{"baseColorFactor", {colour[0], colour[1], colour[2], 1.0}},
                         {"metallicFactor", 0.0},
                         {"roughnessFactor", 0.9}}}});
    }
    return entry->second;
  }
  const Json& list() const { return list_; }

 private:
  std::map<std::pair<bool, std::string>, std::size_t> numbers_;
  Json list_ = Json::array();
};

class GlbWriter {
 public:
  GlbWriter(const fs::path& path, const SpoolReader& spool, const SeamEdges& seams)
      : path_(path), spool_(spool), seams_(seams), binary_(path, binary_path(path)) {}

  static fs::path binary_path(const fs::path& path) {
    return path.parent_path() / ("." + path.filename().string() + ".bin.tmp");
  }

  void write(const fs::path& temporary) {
    nodes_.push_back(root());
    for (const bool obstacles : {false, true}) add_meshes(obstacles);
    if (!binary_.close()) fail(path_);
    write_file(temporary, text());
  }

 private:
  /// z up to y up, and the origin.
  Json root() const {
    const Vec3<double>& o = spool_.origin();
    Json node{{"name", "World"}, {"rotation", {-std::sqrt(0.5), 0.0, 0.0, std::sqrt(0.5)}}};
    if (o != Vec3<double>{0, 0, 0}) node["translation"] = {o[0], o[2], -o[1]};
    node["children"] = Json::array();
    return node;
  }

  void add_meshes(bool obstacles) {
    const std::size_t group = nodes_.size();
    Json children = Json::array();
    nodes_.push_back({{"name", obstacles ? "obstacles" : "cloths"}});
    for (std::size_t m = 0; m < spool_.meshes().size(); ++m) {
      if (spool_.meshes()[m].obstacle != obstacles) continue;
      children.push_back(nodes_.size());
      add_mesh(m);
    }
    if (children.empty()) {
      nodes_.erase(group);
      return;
    }
    nodes_[group]["children"] = std::move(children);
    nodes_[0]["children"].push_back(group);
  }

  void add_mesh(std::size_t m) {
    const std::size_t last = spool_.frames().size() - 1;
    const SpooledMesh& about = spool_.meshes()[m];
    if (spool_.block(last, m).topology_from != 0)
      throw SceneError(path_.string(), "triangles of " + one_line(about.name),
                       "others than in the first frame",
                       "for .glb a topology that stays as it is; .usda and numbered .obj and .ply "
                       "may change it");
    const Mesh first = spool_.read(0, m);
    const Corners corners(first);
    const std::string name = one_line(about.name);
    Json node{{"name", name}, {"mesh", meshes_.size()}};
    Json attributes{
        {"POSITION", binary_.add_vertices(corners.with_repeated(in_single(first.positions)))},
        {"NORMAL", binary_.add_vertices(corners.with_repeated(vertex_normals(first)))}};
    if (!corners.coordinates().empty())
      attributes["TEXCOORD_0"] =
          binary_.add(corners.coordinates(), type_float, "VEC2", target_vertices);
    Json mesh{{"name", name}};
    Json targets = Json::array();
    const bool moves = spool_.block(last, m).points_from != 0;
    const auto placements =
        moves && about.obstacle ? rigid_motion(m, first) : std::vector<Similarity>();
    if (!placements.empty())
      add_motion(placements, node);
    else if (moves)
      targets = add_targets(m, first, corners, mesh);
    mesh["primitives"] = primitives(about, first, corners, attributes, targets);
    if (m < seams_.size() && !seams_[m].empty())
      mesh["primitives"].push_back(seam_lines(seams_[m], attributes, targets));
    meshes_.push_back(std::move(mesh));
    nodes_.push_back(std::move(node));
  }

  /// One for each material and panel.
  Json primitives(const SpooledMesh& about, const Mesh& mesh, const Corners& corners,
                  const Json& attributes, const Json& targets) {
    std::map<std::pair<Index, Index>, std::vector<Tri>> by_labels;
    const std::vector<Tri>& triangles = corners.triangles(mesh);
    for (std::size_t t = 0; t < triangles.size(); ++t)
      by_labels[{mesh.group.empty() ? -1 : mesh.group[t], mesh.part.empty() ? -1 : mesh.part[t]}]
          .push_back(triangles[t]);
    Json list = Json::array();
    for (const auto& [labels, own] : by_labels) {
      const auto [group, panel] = labels;
      std::vector<std::uint32_t> indices;
      for (const Tri& tri : own)
        for (const Index v : tri.v) indices.push_back(static_cast<std::uint32_t>(v));
      const std::string material =
          group < 0 ? std::string() : about.group_names[static_cast<std::size_t>(group)];
      Json primitive{{"attributes", attributes},
                     {"indices", binary_.add(indices, type_index, "SCALAR", target_indices)},
                     {"material", materials_.number_of(material, about.obstacle)}};
      if (!targets.empty()) primitive["targets"] = targets;
      if (panel >= 0) primitive["extras"] = panel_extras(about, static_cast<std::size_t>(panel));
      list.push_back(std::move(primitive));
    }
    return list;
  }

  Json seam_lines(const std::vector<std::array<Index, 2>>& edges, const Json& attributes,
                  const Json& targets) {
    constexpr int lines = 1;
    std::vector<std::uint32_t> indices;
    for (const auto& edge : edges)
      for (const Index v : edge) indices.push_back(static_cast<std::uint32_t>(v));
    Json primitive{{"attributes", attributes},
                   {"indices", binary_.add(indices, type_index, "SCALAR", target_indices)},
                   {"mode", lines},
                   {"material", materials_.number_of("seams", false)},
                   {"extras", {{"seams", true}}}};
    if (!targets.empty()) primitive["targets"] = targets;
    return primitive;
  }

  static Json panel_extras(const SpooledMesh& about, std::size_t panel) {
    Json extras{{"panel", one_line(about.part_names[panel])}};
    if (panel < about.part_labels.size() && !about.part_labels[panel].empty())
      extras["label"] = one_line(about.part_labels[panel]);
    return extras;
  }

  /// [frames] places of a mesh that keeps its shape; empty: it does not
  std::vector<Similarity> rigid_motion(std::size_t m, const Mesh& first) const {
    double size = 0;
    std::vector<Similarity> placements;
    for (std::size_t f = 0; f < spool_.frames().size(); ++f) {
      if (spool_.block(f, m).points_from != f) {
        placements.push_back(placements.back());
        continue;
      }
      const std::vector<Vec3<double>> points = spool_.read(f, m).positions;
      if (points.size() != first.positions.size()) return {};
      Similarity fit;
      if (f > 0) fit = fitted_similarity(first.positions, points);
      for (const Vec3<double>& x : points)
        for (int k = 0; k < 3; ++k) size = std::max(size, std::abs(x[k]));
      for (std::size_t v = 0; v < points.size(); ++v)
        if (!(length(fit(first.positions[v]) - points[v]) <= rigid_tolerance * size)) return {};
      // Of the two quaternions of a rotation the one nearer to that of the frame before.
      double product = 0;
      for (std::size_t k = 0; f > 0 && k < 4; ++k)
        product += fit.rotation[k] * placements.back().rotation[k];
      for (double& x : fit.rotation)
        if (product < 0) x = -x;
      placements.push_back(fit);
    }
    return placements;
  }

  void add_motion(const std::vector<Similarity>& placements, Json& node) {
    node["translation"] = {0.0, 0.0, 0.0};
    node["rotation"] = {0.0, 0.0, 0.0, 1.0};
    node["scale"] = {1.0, 1.0, 1.0};
    std::vector<Vec3<float>> translations, scales;
    std::vector<std::array<float, 4>> rotations;
    for (const Similarity& p : placements) {
      translations.push_back(vec_cast<float>(p.translate));
      const auto scale = static_cast<float>(p.scale);
      scales.push_back({scale, scale, scale});
      std::array<float, 4> rotation{};
      for (std::size_t k = 0; k < 4; ++k) rotation[k] = static_cast<float>(p.rotation[k]);
      rotations.push_back(rotation);
    }
    add_channel("translation", binary_.add(translations, type_float, "VEC3"));
    add_channel("rotation", binary_.add(rotations, type_float, "VEC4"));
    add_channel("scale", binary_.add(scales, type_float, "VEC3"));
  }

  /// A target for each frame with points of its own but the first, and their weights: 1 in the
  /// frames that have these points.
  Json add_targets(std::size_t m, const Mesh& first, const Corners& corners, Json& mesh) {
    const std::vector<Vec3<float>> points = in_single(first.positions);
    const std::vector<Vec3<float>> normals = vertex_normals(first);
    const std::size_t frames = spool_.frames().size();
    Json targets = Json::array();
    Json names = Json::array();
    std::map<std::uint32_t, std::size_t> target_of;  // by the frame that has the points
    for (std::size_t f = 1; f < frames; ++f) {
      if (spool_.block(f, m).points_from != f) continue;
      const Mesh now = spool_.read(f, m);
      if (now.positions.size() != first.positions.size())
        throw SceneError(path_.string(), "vertices of " + one_line(spool_.meshes()[m].name),
                         std::to_string(now.positions.size()),
                         std::to_string(first.positions.size()) + ", as in the first frame");
      target_of.emplace(static_cast<std::uint32_t>(f), targets.size());
      const auto moved = difference(in_single(now.positions), points);
      const auto turned = difference(vertex_normals(now), normals);
      targets.push_back({{"POSITION", binary_.add_vertices(corners.with_repeated(moved))},
                         {"NORMAL", binary_.add_vertices(corners.with_repeated(turned))}});
      names.push_back("frame " + std::to_string(spool_.frames()[f]));
    }
    std::vector<float> weights(frames * targets.size(), 0);
    for (std::size_t f = 0; f < frames; ++f)
      if (const auto target = target_of.find(spool_.block(f, m).points_from);
          target != target_of.end())
        weights[f * targets.size() + target->second] = 1;
    add_channel("weights", binary_.add(weights, type_float, "SCALAR"));
    mesh["weights"] = std::vector<float>(targets.size(), 0);
    mesh["extras"] = {{"targetNames", std::move(names)}};
    return targets;
  }

  /// A property of the node that comes next.
  void add_channel(const char* property, std::size_t output) {
    if (!times_) {
      std::vector<float> times;
      for (const int frame : spool_.frames())
        times.push_back(static_cast<float>(frame / spool_.frame_rate()));
      times_ = binary_.add_times(times);
    }
    channels_.push_back(
        {{"sampler", samplers_.size()}, {"target", {{"node", nodes_.size()}, {"path", property}}}});
    samplers_.push_back({{"input", *times_}, {"interpolation", "LINEAR"}, {"output", output}});
  }

  std::string text() const {
    Json all;
    all["asset"]["version"] = "2.0";
    all["asset"]["generator"] = std::string("weft ") + WEFT_VERSION;
    all["scene"] = 0;
    all["scenes"][0]["nodes"][0] = 0;
    all["nodes"] = nodes_;
    all["meshes"] = meshes_;
    all["materials"] = materials_.list();
    if (!channels_.empty()) {
      Json& animation = all["animations"][0];
      animation["name"] = "simulation";
      animation["samplers"] = samplers_;
      animation["channels"] = channels_;
    }
    all["accessors"] = binary_.accessors();
    all["bufferViews"] = binary_.views();
    all["buffers"][0]["byteLength"] = binary_.size();
    return all.dump();
  }

  void write_file(const fs::path& temporary, std::string text) const {
    text.resize((text.size() + 3) / 4 * 4, ' ');
    constexpr std::size_t heads = 12 + 8 + 8;
    const std::size_t length = heads + text.size() + binary_.size();
    if (static_cast<double>(length) > max_glb_bytes)
      throw SceneError(path_.string(), "size", "more than 4 GiB",
                       "less: fewer frames (--frame), or the format usda");
    std::ofstream out(temporary, std::ios::binary | std::ios::trunc);
    const auto number = [&](std::size_t value) {
      const auto narrow = static_cast<std::uint32_t>(value);
      out.write(reinterpret_cast<const char*>(&narrow), sizeof narrow);
    };
    out.write("glTF", 4);
    number(2);
    number(length);
    number(text.size());
    out.write("JSON", 4);
    out.write(text.data(), static_cast<std::streamsize>(text.size()));
    number(binary_.size());
    out.write("BIN\0", 4);
    out << std::ifstream(binary_path(path_), std::ios::binary).rdbuf();
    out.close();
    if (!out.good()) fail(path_);
  }

  const fs::path& path_;
  const SpoolReader& spool_;
  const SeamEdges& seams_;
  Binary binary_;
  Materials materials_;
  Json nodes_ = Json::array();
  Json meshes_ = Json::array();
  Json samplers_ = Json::array();
  Json channels_ = Json::array();
  std::optional<std::size_t> times_;
};

}  // namespace

void write_glb(const fs::path& path, const SpoolReader& spool, const SeamEdges& seams) {
  const std::size_t frames = spool.frames().size();
  if (frames == 0)
    throw SceneError(spool.path().string(), "frames", "none", "at least one whole frame");
  if (frames > static_cast<std::size_t>(max_glb_frames))
    throw SceneError(path.string(), "frames", std::to_string(frames),
                     "up to " + std::to_string(max_glb_frames) +
                         " in a .glb: some of them (--frame), or the format usda");
  const TemporaryFile binary{GlbWriter::binary_path(path)};
  const TemporaryFile temporary{path.parent_path() / ("." + path.filename().string() + ".tmp")};
  GlbWriter(path, spool, seams).write(temporary.path);
  rename_file(temporary.path, path);
}

}  // namespace weft::io
