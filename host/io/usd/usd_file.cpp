#include "host/io/usd/usd_file.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <system_error>
#include <utility>

#include "host/base/file_operations.hpp"
#include "host/input/counted.hpp"
#include "host/input/safe_text.hpp"
#include "host/io/mesh/mesh_formats.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t max_entries = static_cast<std::size_t>(std::numeric_limits<Index>::max()) / 3;

/// Numbers of one attribute of one mesh at one instant.
class ArrayReader {
 public:
  ArrayReader(const std::string& file, const UsdMeshPrim& prim, const char* attribute,
              std::string_view text)
      : file_(file), prim_(prim), attribute_(attribute), text_(text) {}

  /// "[(x, y), ...]", each number rounded to single precision, as USD has it.
  template <int N>
  std::vector<Vec<double, N>> tuples() {
    std::vector<Vec<double, N>> values;
    need('[');
    while (!take(']')) {
      Vec<double, N> x{};
      need('(');
      for (int k = 0; k < N; ++k) {
        if (k > 0) need(',');
        x[k] = static_cast<double>(static_cast<float>(number()));
        if (!std::isfinite(x[k]))
          refuse(std::isnan(x[k]) ? "nan" : "inf", "a finite number", values.size());
      }
      need(')');
      values.push_back(x);
      if (values.size() > max_entries) refuse("too many entries", "fewer", values.size());
      if (!take(',')) {
        need(']');
        break;
      }
    }
    return values;
  }

  /// "[1, 2, ...]", none negative.
  std::vector<Index> integers() {
    std::vector<Index> values;
    need('[');
    while (!take(']')) {
      const double x = number();
      if (!(x >= 0 && x <= static_cast<double>(max_entries)) || x != std::floor(x))
        refuse(shown(), "a whole number >= 0", values.size());
      values.push_back(static_cast<Index>(x));
      if (!take(',')) {
        need(']');
        break;
      }
    }
    return values;
  }

 private:
  [[noreturn]] void refuse(const std::string& value, const std::string& allowed,
                           std::size_t entry) const {
    throw SceneError(file_, prim_.path + "." + attribute_ + "[" + std::to_string(entry) + "]",
                     value, allowed);
  }
  std::string shown() const { return quoted_start(text_.substr(at_), 20); }
  void skip_space() {
    while (at_ < text_.size()) {
      if (text_[at_] == '#')
        at_ = std::min(text_.find('\n', at_), text_.size());
      else if (text_[at_] == ' ' || text_[at_] == '\t' || text_[at_] == '\r' || text_[at_] == '\n')
        ++at_;
      else
        return;
    }
  }
  bool take(char c) {
    skip_space();
    if (at_ >= text_.size() || text_[at_] != c) return false;
    ++at_;
    return true;
  }
  void need(char c) {
    if (!take(c))
      throw SceneError(file_, prim_.path + "." + attribute_, shown(), std::string("\"") + c + "\"");
  }
  double number() {
    skip_space();
    const std::size_t end = std::min(text_.find_first_of(",)] \t\r\n", at_), text_.size());
    double value = 0;
    if (!parse_number(text_.substr(at_, end - at_), value))
      throw SceneError(file_, prim_.path + "." + attribute_, shown(), "a number");
    at_ = end;
    return value;
  }

  const std::string& file_;
  const UsdMeshPrim& prim_;
  const char* attribute_;
  std::string_view text_;
  std::size_t at_ = 0;
};

/// Names, each once, and their numbers.
struct Names {
  std::vector<std::string> all{};
  std::map<std::string, Index> numbers{};

  Index number_of(const std::string& name) {
    const auto [entry, fresh] = numbers.emplace(name, static_cast<Index>(all.size()));
    if (fresh) all.push_back(name);
    return entry->second;
  }
};

/// A mesh at an instant, part by part.
class MeshReader {
 public:
  MeshReader(const std::string& file, const UsdMeshPrim& prim, double time)
      : file_(file), prim_(prim), time_(time) {}

  Mesh read(Uv uv) {
    mesh_.positions = array("points", prim_.points).tuples<3>();
    counts_ = array("faceVertexCounts", prim_.counts).integers();
    corners_ = array("faceVertexIndices", prim_.indices).integers();
    check_topology();
    left_handed_ = prim_.left_handed != prim_.placement.mirrors();
    add_fans(mesh_.triangles, corners_);
    add_labels();
    if ((uv == Uv::material || uv == Uv::where_some) && !prim_.st.samples.empty()) read_material();
    return std::move(mesh_);
  }

 private:
  [[noreturn]] void refuse(const std::string& attribute, const std::string& value,
                           const std::string& allowed) const {
    throw SceneError(file_, prim_.path + "." + attribute, value, allowed);
  }
  ArrayReader array(const char* name, const UsdAttribute& attribute) const {
    if (attribute.samples.empty()) refuse(name, "nothing", "an array");
    return {file_, prim_, name, attribute.at(time_)};
  }

  void check_topology() const {
    std::size_t corners = 0;
    for (const Index count : counts_) {
      if (count < 3) refuse("faceVertexCounts", counted(count, "corner"), "at least three");
      corners += static_cast<std::size_t>(count);
    }
    if (corners != corners_.size())
      refuse("faceVertexIndices", counted(corners_.size(), "corner"),
             std::to_string(corners) + ", as faceVertexCounts says");
    if (corners_.empty()) refuse("faceVertexCounts", "no faces", "at least one");
    check_range("faceVertexIndices", corners_, mesh_.positions.size());
  }
  void check_range(const char* name, const std::vector<Index>& numbers, std::size_t count) const {
    for (const Index v : numbers)
      if (static_cast<std::size_t>(v) >= count)
        refuse(name, std::to_string(v),
               count == 0 ? "nothing, there are no values" : "0 to " + std::to_string(count - 1));
  }

  /// @param corners what the corners of all faces name, one after the other
  void add_fans(std::vector<Tri>& triangles, const std::vector<Index>& corners) const {
    std::size_t first = 0;
    for (const Index count : counts_) {
      for (std::size_t k = 2; k < static_cast<std::size_t>(count); ++k) {
        const Index a = corners[first + k - 1];
        const Index b = corners[first + k];
        triangles.push_back(left_handed_ ? Tri{{corners[first], b, a}}
                                         : Tri{{corners[first], a, b}});
      }
      first += static_cast<std::size_t>(count);
    }
  }

  /// Groups and parts of the triangles, where the file says anything of them.
  void add_labels() {
    std::vector<Index> label_of(counts_.size(), 0);  // of faces: 0, or subset + 1
    for (std::size_t s = 0; s < prim_.subsets.size(); ++s) {
      if (prim_.subsets[s].indices.samples.empty()) continue;
      const std::vector<Index> faces = array("indices", prim_.subsets[s].indices).integers();
      check_range("indices", faces, counts_.size());
      for (const Index face : faces)
        label_of[static_cast<std::size_t>(face)] = static_cast<Index>(s) + 1;
    }
    Names groups, parts;
    // A subset that no face is in keeps its number: in our own files names have the same in all
    // frames, and subsets hold all faces.
    const std::size_t labels = prim_.subsets.size() + 1;
    std::vector<Index> group_of_label(labels, 0), part_of_label(labels, 0);
    std::map<Index, std::string> panel_labels;
    const bool all_held = std::find(label_of.begin(), label_of.end(), 0) == label_of.end();
    for (std::size_t label = all_held ? 1 : 0; label < labels; ++label) {
      const UsdLabel& own = label == 0 ? prim_.label : prim_.subsets[label - 1].label;
      const std::string& material = own.material.empty() ? prim_.label.material : own.material;
      group_of_label[label] = groups.number_of(material.empty() ? own.part : material);
      part_of_label[label] = parts.number_of(own.part);
      if (!own.panel.empty()) panel_labels.emplace(part_of_label[label], own.panel);
    }
    const auto says_nothing = [](const Names& names) {
      return names.all.size() == 1 && names.all.front().empty();
    };
    if (says_nothing(groups)) return;
    for (std::size_t face = 0; face < counts_.size(); ++face) {
      const auto label = static_cast<std::size_t>(label_of[face]);
      const auto triangles = static_cast<std::size_t>(counts_[face]) - 2;
      mesh_.group.insert(mesh_.group.end(), triangles, group_of_label[label]);
      if (!says_nothing(parts))
        mesh_.part.insert(mesh_.part.end(), triangles, part_of_label[label]);
    }
    mesh_.group_names = std::move(groups.all);
    if (mesh_.part.empty()) return;
    mesh_.part_names = std::move(parts.all);
    if (panel_labels.empty()) return;
    mesh_.part_labels.resize(mesh_.part_names.size());
    for (const auto& [part, label] : panel_labels)
      mesh_.part_labels[static_cast<std::size_t>(part)] = label;
  }

  void read_material() {
    std::vector<Vec2<double>> st = array("primvars:st", prim_.st).tuples<2>();
    if (st.empty()) return;
    std::vector<Index> indices;
    if (!prim_.st_indices.samples.empty())
      indices = array("primvars:st:indices", prim_.st_indices).integers();
    const std::size_t wanted = prim_.st_face_varying ? corners_.size() : mesh_.positions.size();
    if (indices.empty()) {
      for (std::size_t i = 0; i < std::min(wanted, st.size()); ++i)
        indices.push_back(static_cast<Index>(i));
    }
    if (indices.size() != wanted || (prim_.st_indices.samples.empty() && st.size() != wanted))
      refuse("primvars:st", std::to_string(std::max(indices.size(), st.size())) + " values",
             std::to_string(wanted) + ", one a " + (prim_.st_face_varying ? "corner" : "vertex"));
    check_range("primvars:st:indices", indices, st.size());
    if (prim_.st_face_varying) {
      mesh_.material = std::move(st);
      add_fans(mesh_.material_triangles, indices);
      return;
    }
    for (const Index i : indices) mesh_.material.push_back(st[static_cast<std::size_t>(i)]);
  }

  const std::string& file_;
  const UsdMeshPrim& prim_;
  double time_;
  Mesh mesh_;
  bool left_handed_ = false;
  std::vector<Index> counts_;
  std::vector<Index> corners_;
};

}  // namespace

MappedFile::MappedFile(const fs::path& path) {
  const FileDescriptor file = open_regular_file(path, O_RDONLY, "read");
  struct stat status = {};
  if (::fstat(file.number(), &status) != 0) fail_on(path, "read");
  size_ = static_cast<std::size_t>(status.st_size);
  if (size_ == 0) return;
  void* data = ::mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, file.number(), 0);
  if (data == MAP_FAILED) fail_on(path, "read");
  data_ = data;
}

MappedFile::~MappedFile() {
  if (data_) ::munmap(data_, size_);
}

std::string_view UsdAttribute::at(double time) const {
  auto after = std::upper_bound(samples.begin(), samples.end(), time,
                                [](double t, const UsdSample& s) { return t < s.time; });
  if (!timed || after == samples.begin()) return samples.front().value;
  return (after - 1)->value;
}

UsdFile::UsdFile(const fs::path& path)
    : file_(path.string()), mapped_(std::make_unique<MappedFile>(path)) {
  stage_ = parse_usd(mapped_->bytes(), file_);
  if (stage_.meshes.empty()) throw SceneError(file_, "meshes", "none", "at least one Mesh prim");
  for (const UsdMeshPrim& prim : stage_.meshes)
    for (const UsdSample& sample : prim.points.samples)
      if (prim.points.timed) times_.push_back(sample.time);
  std::sort(times_.begin(), times_.end());
  times_.erase(std::unique(times_.begin(), times_.end()), times_.end());
  if (times_.empty()) times_.push_back(0);
}

Vec3<double> UsdFile::in_metres(Vec3<double> x) const {
  if (stage_.y_up) x = {x[0], -x[2], x[1]};
  if (stage_.meters_per_unit != 1) x *= stage_.meters_per_unit;
  return x;
}

Vec3<double> UsdFile::origin(std::size_t mesh) const {
  return in_metres(stage_.meshes[mesh].placement.translate);
}

Mesh UsdFile::read(std::size_t mesh, double time, Uv uv) const {
  Mesh result = MeshReader(file_, stage_.meshes[mesh], time).read(uv);
  const UsdPlacement& placement = stage_.meshes[mesh].placement;
  const bool turns = !placement.only_translates();
  for (Vec3<double>& x : result.positions) {
    x = in_metres(turns ? placement.turned(x) : x);
    if (!std::isfinite(x[0]) || !std::isfinite(x[1]) || !std::isfinite(x[2]))
      throw SceneError(file_, stage_.meshes[mesh].path + ".points", "inf with metersPerUnit",
                       "finite numbers of metres");
  }
  return result;
}

std::vector<Vec3<double>> UsdFile::velocities(std::size_t mesh, double time) const {
  const UsdMeshPrim& prim = stage_.meshes[mesh];
  if (prim.velocities.samples.empty()) return {};
  std::vector<Vec3<double>> result =
      ArrayReader(file_, prim, "velocities", prim.velocities.at(time)).tuples<3>();
  const bool turns = !prim.placement.only_translates();
  for (Vec3<double>& v : result) v = in_metres(turns ? prim.placement.turned(v) : v);
  return result;
}

}  // namespace weft::io
