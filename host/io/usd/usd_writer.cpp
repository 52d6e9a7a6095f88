#include <algorithm>
#include <charconv>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "host/base/file_operations.hpp"
#include "host/base/temporary_file.hpp"
#include "host/geometry/aabb.hpp"
#include "host/geometry/vertex_normals.hpp"
#include "host/input/safe_text.hpp"
#include "host/io/spool/material_colour.hpp"
#include "host/io/usd/usd_file.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

namespace fs = std::filesystem;

/// Text on its way to a file, a piece at a time.
class TextFile {
 public:
  explicit TextFile(const fs::path& path) : stream_(path, std::ios::binary | std::ios::trunc) {}

  TextFile& operator<<(std::string_view text) {
    text_ += text;
    if (text_.size() > piece) flush();
    return *this;
  }
  template <class Number>
  void number(Number value) {
    char digits[32];
    text_.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
    if (text_.size() > piece) flush();
  }
  template <class T, int N>
  void tuple(const Vec<T, N>& value) {
    *this << "(";
    for (int k = 0; k < N; ++k) {
      if (k > 0) *this << ", ";
      number(static_cast<float>(value[k]));
    }
    *this << ")";
  }
  /// @return whether all of it was written
  bool close() {
    flush();
    stream_.close();
    return stream_.good();
  }

 private:
  static constexpr std::size_t piece = 1 << 20;

  void flush() {
    stream_.write(text_.data(), static_cast<std::streamsize>(text_.size()));
    text_.clear();
  }

  std::ofstream stream_;
  std::string text_;
};

template <class T, int N>
void write_array(TextFile& out, const std::vector<Vec<T, N>>& values) {
  out << "[";
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i > 0) out << ", ";
    out.tuple(values[i]);
  }
  out << "]";
}

void write_corners(TextFile& out, const std::vector<Tri>& triangles) {
  out << "[";
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      if (t > 0 || k > 0) out << ", ";
      out.number(triangles[t].v[k]);
    }
  out << "]";
}

void write_counts(TextFile& out, const std::vector<Tri>& triangles) {
  out << "[";
  for (std::size_t t = 0; t < triangles.size(); ++t) out << (t > 0 ? ", 3" : "3");
  out << "]";
}

void write_extent(TextFile& out, const std::vector<Vec3<double>>& points) {
  const Aabb box = points.empty() ? Aabb{{0, 0, 0}, {0, 0, 0}} : aabb_of(points);
  write_array(out, std::vector<Vec3<double>>{box.lo, box.hi});
}

/// A name that USD takes: letters, digits and _, no digit in front, none of its siblings'.
std::string identifier(const std::string& name, std::set<std::string>& taken) {
  std::string made = name;
  for (char& c : made) {
    const bool good = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    if (!good) c = '_';
  }
  if (made.empty() || (made[0] >= '0' && made[0] <= '9')) made.insert(0, "_");
  std::string result = made;
  for (int k = 1; !taken.insert(result).second; ++k) result = made + "_" + std::to_string(k);
  return result;
}

/// A part of a mesh, and its material.
struct Subset {
  std::string part;
  std::string material;
  bool operator<(const Subset& other) const {
    return std::tie(part, material) < std::tie(other.part, other.material);
  }
};

/// Subsets by name, with the labels of their triangles; a mesh without parts has the part -1.
using Subsets = std::map<Subset, std::pair<Index, Index>>;

std::pair<Index, Index> labels_of(const Mesh& mesh, std::size_t triangle) {
  return {mesh.part.empty() ? -1 : mesh.part[triangle], mesh.group[triangle]};
}

/// All that a mesh has in any frame; none if nothing is known of its materials.
Subsets subsets_of(const SpoolReader& spool, std::size_t mesh) {
  std::set<std::pair<Index, Index>> found;
  for (std::size_t f = 0; f < spool.frames().size(); ++f) {
    const SpoolBlock& block = spool.block(f, mesh);
    if (block.topology_from != f || !block.grouped) continue;
    const Mesh content = spool.read(f, mesh);
    for (std::size_t t = 0; t < content.triangles.size(); ++t) found.insert(labels_of(content, t));
  }
  const SpooledMesh& about = spool.meshes()[mesh];
  Subsets subsets;
  for (const auto& [part, group] : found)
    subsets.emplace(
        Subset{part < 0 ? std::string() : about.part_names[static_cast<std::size_t>(part)],
               about.group_names[static_cast<std::size_t>(group)]},
        std::pair(part, group));
  return subsets;
}

/// Prims of the materials, by name.
using Materials = std::map<std::string, std::string>;

/// Writes one mesh prim: attribute by attribute, each over all frames.
class PrimWriter {
 public:
  PrimWriter(TextFile& out, const SpoolReader& spool, std::size_t mesh, const Subsets& subsets,
             const Materials& materials)
      : out_(out), spool_(spool), mesh_(mesh), subsets_(subsets), materials_(materials) {
    const std::size_t last = spool.frames().size() - 1;
    still_ = spool.block(last, mesh).points_from == 0;
    one_topology_ = spool.block(last, mesh).topology_from == 0;
    for (std::size_t f = 0; f <= last; ++f) {
      const SpoolBlock& own = spool.block(f, mesh);
      with_st_ = with_st_ || spool.block(own.topology_from, mesh).material > 0;
      face_varying_ = face_varying_ || spool.block(own.topology_from, mesh).material_triangles > 0;
    }
  }

  void write(const std::string& prim) {
    const SpooledMesh& mesh = spool_.meshes()[mesh_];
    const bool whole = subsets_.size() == 1;
    out_ << "        def Mesh \"" << prim << "\"";
    if (whole) write_binding_schema("        ");
    out_ << "\n        {\n";
    if (whole) write_binding(indent, subsets_.begin()->first);
    out_ << indent << "uniform bool doubleSided = " << (mesh.obstacle ? "0" : "1") << "\n";
    out_ << indent << "uniform token subdivisionScheme = \"none\"\n";
    out_ << indent << "custom string weft:name = " << usd_text(mesh.name) << "\n";
    topology("int[] faceVertexCounts", "", [&](const Mesh& m) { write_counts(out_, m.triangles); });
    topology("int[] faceVertexIndices", "",
             [&](const Mesh& m) { write_corners(out_, m.triangles); });
    moving("float3[] extent", "", [&](const Mesh& m) { write_extent(out_, m.positions); });
    moving("point3f[] points", "", [&](const Mesh& m) { write_array(out_, m.positions); });
    moving("normal3f[] normals", "vertex",
           [&](const Mesh& m) { write_array(out_, vertex_normals(m)); });
    write_velocities();
    if (with_st_) write_st();
    if (subsets_.size() > 1) write_subsets();
    out_ << "        }\n";
  }

 private:
  static constexpr std::string_view indent = "            ";

  void write_binding_schema(std::string_view before) {
    out_ << " (\n"
         << before << "    prepend apiSchemas = [\"MaterialBindingAPI\"]\n"
         << before << ")";
  }

  void write_binding(std::string_view before, const Subset& subset) {
    out_ << before << "custom string weft:material = " << usd_text(subset.material) << "\n";
    if (!subset.part.empty())
      out_ << before << "custom string weft:part = " << usd_text(subset.part) << "\n";
    if (const std::string label = label_of(subset.part); !label.empty())
      out_ << before << "custom string weft:label = " << usd_text(label) << "\n";
    out_ << before << "rel material:binding = </World/materials/" << materials_.at(subset.material)
         << ">\n";
  }

  /// What a panel is labelled as; empty: nothing.
  std::string label_of(const std::string& part) const {
    const SpooledMesh& mesh = spool_.meshes()[mesh_];
    for (std::size_t p = 0; p < mesh.part_labels.size() && !part.empty(); ++p)
      if (mesh.part_names[p] == part) return mesh.part_labels[p];
    return {};
  }

  /// A prim for the faces of each part and material.
  void write_subsets() {
    out_ << indent << "uniform token subsetFamily:materialBind:familyType = \"partition\"\n";
    std::set<std::string> taken;
    for (const auto& [subset, labels] : subsets_) {
      const std::string& name = subset.part.empty() ? subset.material : subset.part;
      out_ << "\n" << indent << "def GeomSubset \"" << identifier(name, taken) << "\"";
      write_binding_schema(indent);
      out_ << "\n" << indent << "{\n";
      const std::string inner = std::string(indent) + "    ";
      out_ << inner << "uniform token elementType = \"face\"\n"
           << inner << "uniform token familyName = \"materialBind\"\n";
      write_binding(inner, subset);
      const auto& own = labels;
      topology("    int[] indices", "", [&](const Mesh& m) {
        out_ << "[";
        bool first = true;
        for (std::size_t t = 0; t < m.group.size(); ++t) {
          if (labels_of(m, t) != own) continue;
          if (!std::exchange(first, false)) out_ << ", ";
          out_.number(t);
        }
        out_ << "]";
      });
      out_ << indent << "}\n";
    }
  }

  /// [m/s] those of the state where they are known, otherwise differences between frames of one
  /// topology; zero where there is no such frame.
  void write_velocities() {
    if (still_ && one_topology_) return;
    begin_samples("vector3f[] velocities", "");
    for (std::size_t f = 0; f < spool_.frames().size(); ++f) {
      out_ << indent << "    ";
      out_.number(spool_.frames()[f]);
      out_ << ": ";
      write_array(out_, velocities(f));
      out_ << ",\n";
    }
    out_ << indent << "}\n";
  }

  std::vector<Vec3<double>> velocities(std::size_t frame) const {
    std::vector<Vec3<double>> known = spool_.velocities(frame, mesh_);
    if (!known.empty()) return known;
    const auto topology_of = [&](std::size_t f) { return spool_.block(f, mesh_).topology_from; };
    const std::size_t last = spool_.frames().size() - 1;
    const std::size_t from =
        frame > 0 && topology_of(frame - 1) == topology_of(frame) ? frame - 1 : frame;
    const std::size_t to =
        frame < last && topology_of(frame + 1) == topology_of(frame) ? frame + 1 : frame;
    const std::vector<Vec3<double>> before = spool_.read(from, mesh_).positions;
    std::vector<Vec3<double>> result = spool_.read(to, mesh_).positions;
    const int frames = std::max(1, spool_.frames()[to] - spool_.frames()[from]);
    for (std::size_t v = 0; v < result.size(); ++v)
      result[v] = (result[v] - before[v]) * (spool_.frame_rate() / frames);
    return result;
  }

  void write_st() {
    topology("texCoord2f[] primvars:st", face_varying_ ? "faceVarying" : "vertex",
             [&](const Mesh& m) { write_array(out_, m.material); });
    if (!face_varying_) return;
    topology("int[] primvars:st:indices", "", [&](const Mesh& m) {
      write_corners(out_, m.material.empty()             ? std::vector<Tri>()
                          : m.material_triangles.empty() ? m.triangles
                                                         : m.material_triangles);
    });
  }

  /// One value, or one each time the topology changes. Readers blend between samples of what is no
  /// whole number (primvars:st), so there the old value is said again just before the new one.
  template <class Write>
  void topology(const std::string& name, std::string_view interpolation, Write&& write) {
    if (one_topology_) return once(name, interpolation, write);
    begin_samples(name, interpolation);
    const std::size_t count = spool_.frames().size();
    for (std::size_t f = 0; f < count; ++f) {
      const bool fresh = spool_.block(f, mesh_).topology_from == f;
      const bool ends = f + 1 < count && spool_.block(f + 1, mesh_).topology_from == f + 1;
      if (fresh || (!interpolation.empty() && ends)) sample(f, write);
    }
    out_ << indent << "}\n";
  }

  /// One value if the mesh never moves, otherwise one a frame.
  template <class Write>
  void moving(const std::string& name, std::string_view interpolation, Write&& write) {
    if (still_ && one_topology_) return once(name, interpolation, write);
    begin_samples(name, interpolation);
    for (std::size_t f = 0; f < spool_.frames().size(); ++f) sample(f, write);
    out_ << indent << "}\n";
  }

  /// @param interpolation of the values over the mesh; empty: not said
  void add_interpolation(std::string_view interpolation) {
    if (interpolation.empty()) return;
    out_ << " (\n"
         << indent << "    interpolation = \"" << interpolation << "\"\n"
         << indent << ")";
  }

  void begin_samples(const std::string& name, std::string_view interpolation) {
    if (!interpolation.empty()) {
      out_ << indent << name;
      add_interpolation(interpolation);
      out_ << "\n";
    }
    out_ << indent << name << ".timeSamples = {\n";
  }

  template <class Write>
  void once(const std::string& name, std::string_view interpolation, Write&& write) {
    out_ << indent << name << " = ";
    write(spool_.read(0, mesh_));
    add_interpolation(interpolation);
    out_ << "\n";
  }

  template <class Write>
  void sample(std::size_t frame, Write&& write) {
    out_ << indent << "    ";
    out_.number(spool_.frames()[frame]);
    out_ << ": ";
    write(spool_.read(frame, mesh_));
    out_ << ",\n";
  }

  TextFile& out_;
  const SpoolReader& spool_;
  std::size_t mesh_;
  const Subsets& subsets_;
  const Materials& materials_;
  bool still_ = false;
  bool one_topology_ = false;
  bool with_st_ = false;
  bool face_varying_ = false;
};

void write_header(TextFile& out, const SpoolReader& spool) {
  out << "#usda 1.0\n(\n    defaultPrim = \"World\"\n    doc = \"weft\"\n    endTimeCode = ";
  out.number(spool.frames().back());
  out << "\n    framesPerSecond = ";
  out.number(spool.frame_rate());
  out << "\n    metersPerUnit = 1\n    startTimeCode = ";
  out.number(spool.frames().front());
  out << "\n    timeCodesPerSecond = ";
  out.number(spool.frame_rate());
  out << "\n    upAxis = \"Z\"\n)\n\n";
}

/// The origin of the points as a transform of the prim around all meshes.
void write_origin(TextFile& out, const Vec3<double>& origin) {
  if (origin == Vec3<double>{0, 0, 0}) return;
  out << "    double3 xformOp:translate = (";
  for (int k = 0; k < 3; ++k) {
    if (k > 0) out << ", ";
    out.number(origin[k]);
  }
  out << ")\n    uniform token[] xformOpOrder = [\"xformOp:translate\"]\n\n";
}

/// All materials of all meshes.
/// @return their prims, by name
Materials materials_of(const std::vector<Subsets>& subsets) {
  Materials materials;
  for (const Subsets& of_mesh : subsets)
    for (const auto& [subset, labels] : of_mesh) materials.emplace(subset.material, "");
  std::set<std::string> taken;
  for (auto& [name, prim] : materials) prim = identifier(name, taken);
  return materials;
}

void write_materials(TextFile& out, const Materials& materials) {
  if (materials.empty()) return;
  out << "\n    def Scope \"materials\"\n    {\n";
  std::size_t number = 0;
  for (const auto& [name, prim] : materials) {
    if (number > 0) out << "\n";
    const std::string path = "/World/materials/" + prim;
    out << "        def Material \"" << prim << "\"\n        {\n"
        << "            custom string weft:name = " << usd_text(name) << "\n"
        << "            token outputs:surface.connect = <" << path
        << "/surface.outputs:surface>\n\n"
        << "            def Shader \"surface\"\n            {\n"
        << "                uniform token info:id = \"UsdPreviewSurface\"\n"
        << "                color3f inputs:diffuseColor = ";
    out.tuple(material_colour(number++));
    out << "\n                float inputs:roughness = 0.9\n"
        << "                token outputs:surface\n            }\n        }\n";
  }
  out << "    }\n";
}

void write_group(TextFile& out, const SpoolReader& spool, const std::vector<Subsets>& subsets,
                 const Materials& materials, const char* group, bool obstacles) {
  out << "    def Xform \"" << group << "\"\n    {\n";
  std::set<std::string> taken;
  bool first = true;
  for (std::size_t m = 0; m < spool.meshes().size(); ++m) {
    if (spool.meshes()[m].obstacle != obstacles) continue;
    if (!std::exchange(first, false)) out << "\n";
    PrimWriter(out, spool, m, subsets[m], materials)
        .write(identifier(spool.meshes()[m].name, taken));
  }
  out << "    }\n";
}

}  // namespace

void write_usd(const fs::path& path, const SpoolReader& spool) {
  if (spool.frames().empty())
    throw SceneError(spool.path().string(), "frames", "none", "at least one whole frame");
  const TemporaryFile temporary{path.parent_path() / ("." + path.filename().string() + ".tmp")};
  TextFile out(temporary.path);
  write_header(out, spool);
  out << "def Xform \"World\"\n{\n";
  write_origin(out, spool.origin());
  std::vector<Subsets> subsets;
  for (std::size_t m = 0; m < spool.meshes().size(); ++m) subsets.push_back(subsets_of(spool, m));
  const Materials materials = materials_of(subsets);
  write_group(out, spool, subsets, materials, "cloths", false);
  const auto& meshes = spool.meshes();
  if (std::any_of(meshes.begin(), meshes.end(), [](const SpooledMesh& m) { return m.obstacle; })) {
    out << "\n";
    write_group(out, spool, subsets, materials, "obstacles", true);
  }
  write_materials(out, materials);
  out << "}\n";
  if (!out.close()) throw SceneError(path.string() + ": cannot write");
  rename_file(temporary.path, path);
}

}  // namespace weft::io
