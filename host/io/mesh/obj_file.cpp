#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <map>
#include <utility>

#include "host/input/safe_text.hpp"
#include "host/io/mesh/mesh_formats.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

/// Keywords that carry nothing for us: normals, curves, and what ARCSim adds.
constexpr std::array<std::string_view, 23> ignored_keywords{
    "s",  "mtllib", "shadow_obj", "usemap", "vn", "vp", "vv", "lod", "mg", "l",  "p", "vl",
    "ny", "nv",     "nl",         "e",      "ea", "ed", "el", "ts",  "fs", "td", "fd"};

/// Polygons with more corners are split from their first one: finding the best takes n^2.
constexpr std::size_t max_searched_corners = 64;

/// Smallest angle of a triangle; its negative if it faces away from `normal`. [rad]
double least_angle(const Vec3<double>& a, const Vec3<double>& b, const Vec3<double>& c,
                   const Vec3<double>& normal) {
  const auto angle = [](const Vec3<double>& x, const Vec3<double>& y, const Vec3<double>& z) {
    return std::atan2(length(cross(y - x, z - x)), dot(y - x, z - x));
  };
  const double least = std::min({angle(a, b, c), angle(b, c, a), angle(c, a, b)});
  return dot(cross(b - a, c - a), normal) < 0 ? -least : least;
}

/// Labels of triangles by names that hold from one line of the file on.
class FaceLabels {
 public:
  /// @param triangles that there are so far; those before the first name are called ""
  void name_next(const std::string& name, std::size_t triangles) {
    if (names_.empty() && name.empty()) return;
    if (names_.empty() && triangles > 0) number_of("");
    if (names_.empty() || labels_.empty()) labels_.assign(triangles, 0);
    now_ = number_of(name);
  }
  void add_triangle() {
    if (!names_.empty()) labels_.push_back(now_);
  }
  bool empty() const { return names_.empty(); }
  Index now() const { return now_; }
  void go_on_with(Index label) { now_ = label; }
  void relabel_from(std::size_t triangle, Index label) {
    std::fill(labels_.begin() + static_cast<std::ptrdiff_t>(triangle), labels_.end(), label);
  }
  std::vector<Index> take_labels() { return std::move(labels_); }
  std::vector<std::string> take_names() { return std::move(names_); }

 private:
  Index number_of(const std::string& name) {
    const auto [entry, fresh] = numbers_.try_emplace(name, static_cast<Index>(names_.size()));
    if (fresh) names_.push_back(name);
    return entry->second;
  }

  std::vector<Index> labels_;
  std::vector<std::string> names_;
  std::map<std::string, Index, std::less<>> numbers_;
  Index now_ = 0;
};

class ObjReader {
 public:
  ObjReader(const std::string& file, Uv uv) : file_(file), uv_(uv) {}

  Mesh read(std::string_view bytes) {
    constexpr std::string_view byte_order_mark = "\xef\xbb\xbf";
    if (bytes.starts_with(byte_order_mark)) bytes.remove_prefix(byte_order_mark.size());
    while (!bytes.empty()) {
      ++line_number_;
      const std::size_t end = std::min(bytes.find('\n'), bytes.size());
      read_line(bytes.substr(0, end));
      bytes.remove_prefix(std::min(end + 1, bytes.size()));
    }
    finish_label();
    const std::string passed_over = unknown_count_ > 0 ? " (" + unknown_text() + ")" : "";
    if (mesh_.positions.empty())
      throw SceneError(file_, "v", "no vertices" + passed_over, "at least three");
    if (mesh_.triangles.empty())
      throw SceneError(file_, "f", "no faces" + passed_over, "at least one");
    finish_material();
    mesh_.group = groups_.take_labels();
    mesh_.group_names = groups_.take_names();
    // Where no material hides them, parts are groups.
    if (with_materials_ && !parts_.empty()) {
      mesh_.part = parts_.take_labels();
      mesh_.part_names = parts_.take_names();
    }
    // Where no group or material hides them, objects are groups.
    if ((with_materials_ || with_groups_) && !objects_.empty()) {
      mesh_.object = objects_.take_labels();
      mesh_.object_names = objects_.take_names();
      drop_unused_groups();
    }
    take_panel_labels(panel_labels_, mesh_);
    return std::move(mesh_);
  }

  /// What was passed over; empty: nothing.
  std::string warning() const { return unknown_count_ == 0 ? "" : file_ + ": " + unknown_text(); }

 private:
  std::string unknown_text() const {
    return "line " + std::to_string(unknown_line_) + ": keyword " + unknown_keyword_ +
           " is unknown and passed over" +
           (unknown_count_ > 1 ? ", the first of " + std::to_string(unknown_count_) + " such lines"
                               : "");
  }

  struct Corner {
    Index vertex = 0;
    Index texture = -1;
  };

  [[noreturn]] void refuse(const std::string& field, std::string_view value,
                           const std::string& allowed) const {
    // A line of a broken file may be anything: keep the message one short printable line.
    throw SceneError(file_, "line " + std::to_string(line_number_) + ": " + field,
                     quoted_start(value), allowed);
  }

  void read_line(std::string_view line) {
    const std::size_t comment = line.find('#');
    if (comment == 0) read_comment(line.substr(1));
    if (comment != std::string_view::npos) line = line.substr(0, comment);
    std::string_view rest = line;
    const std::string_view keyword = next_word(rest);
    if (keyword.empty()) return;
    if (keyword == "v") {
      read_vertex(rest);
    } else if (keyword == "vt") {
      read_texture(rest);
    } else if (keyword == "f") {
      read_face(rest);
    } else if (keyword == "o" || keyword == "g" || keyword == "usemtl") {
      read_group(keyword, rest);
    } else if (keyword == "fl" || keyword == "tl") {
      read_label(keyword, rest);
    } else if (std::find(ignored_keywords.begin(), ignored_keywords.end(), keyword) ==
               ignored_keywords.end()) {
      note_unknown(keyword);
    }
  }

  /// What format_obj() says of panels.
  void read_comment(std::string_view line) {
    if (next_word(line) != "panel") return;
    const std::string_view panel = next_word(line);
    const std::string_view label = next_word(line);
    if (!label.empty()) panel_labels_.insert_or_assign(one_line(panel), one_line(label));
  }

  void note_unknown(std::string_view keyword) {
    if (unknown_count_++ > 0) return;
    unknown_line_ = line_number_;
    unknown_keyword_ = quoted_start(keyword);
  }

  /// @return how many numbers there were, up to `numbers.size()`
  template <std::size_t N>
  std::size_t read_numbers(std::string_view rest, const char* keyword,
                           std::array<double, N>& numbers) const {
    std::size_t count = 0;
    for (std::string_view word = next_word(rest); !word.empty(); word = next_word(rest)) {
      if (count == N) refuse(keyword, word, "at most " + std::to_string(N) + " numbers");
      if (!parse_number(word, numbers[count]) || !std::isfinite(numbers[count]))
        refuse(std::string(keyword) + "[" + std::to_string(count) + "]", word, "a finite number");
      ++count;
    }
    return count;
  }

  void read_vertex(std::string_view rest) {
    std::array<double, 7> n{};  // x y z, perhaps w, perhaps a colour
    const std::size_t count = read_numbers(rest, "v", n);
    if (count < 3 || count == 5) refuse("v", rest, "x y z");
    if (mesh_.positions.size() >= max_entries) refuse("v", rest, "fewer vertices");
    mesh_.positions.push_back({n[0], n[1], n[2]});
  }

  void read_texture(std::string_view rest) {
    std::array<double, 3> n{};
    if (read_numbers(rest, "vt", n) < 2) refuse("vt", rest, "u v");
    textures_.push_back({n[0], n[1]});
  }

  /// 1-based from the front, or negative from the back.
  Index read_reference(std::string_view word, const char* what, std::size_t count) const {
    long long number = 0;
    const auto known = static_cast<long long>(count);
    const bool good =
        parse_number(word, number) && number != 0 && number <= known && number >= -known;
    if (!good)
      refuse(std::string("f ") + what, word,
             count == 0
                 ? "nothing, none is given before"
                 : "1 to " + std::to_string(known) + " or -" + std::to_string(known) + " to -1");
    return static_cast<Index>(number > 0 ? number - 1 : known + number);
  }

  Corner read_corner(std::string_view word) const {
    const std::size_t slash = std::min(word.find('/'), word.size());
    Corner corner;
    corner.vertex = read_reference(word.substr(0, slash), "vertex", mesh_.positions.size());
    if (slash == word.size()) return corner;
    std::string_view texture = word.substr(slash + 1);
    texture = texture.substr(0, std::min(texture.find('/'), texture.size()));
    // "1//3" has a normal and no texture coordinate
    if (texture.empty() && word.substr(slash).size() > 2 && word[slash + 1] == '/') return corner;
    corner.texture = read_reference(texture, "texture", textures_.size());
    return corner;
  }

  void read_face(std::string_view rest) {
    corners_.clear();
    const std::string_view whole = rest;
    for (std::string_view word = next_word(rest); !word.empty(); word = next_word(rest))
      corners_.push_back(read_corner(word));
    if (corners_.size() < 3) refuse("f", whole, "at least three corners");
    if (mesh_.triangles.size() + corners_.size() > max_entries) refuse("f", whole, "fewer faces");
    if (uv_ != Uv::ignore) note_textures();
    finish_label();
    face_begin_ = mesh_.triangles.size();
    if (uv_ == Uv::material || uv_ == Uv::where_all) turn_to_best_corner();
    for (std::size_t k = 2; k < corners_.size(); ++k) {
      const Corner& a = corners_[0];
      const Corner& b = corners_[k - 1];
      const Corner& c = corners_[k];
      mesh_.triangles.push_back({{a.vertex, b.vertex, c.vertex}});
      if (uv_ != Uv::ignore)
        mesh_.material_triangles.push_back({{a.texture, b.texture, c.texture}});
      groups_.add_triangle();
      parts_.add_triangle();
      objects_.add_triangle();
    }
  }

  /// Puts that corner first from which a fan has the largest smallest angle. Only where the split
  /// is the cloth's own: the frames of a sequence must all be split alike.
  void turn_to_best_corner() {
    const std::size_t n = corners_.size();
    if (n == 3 || n > max_searched_corners) return;
    const auto position = [&](std::size_t k) {
      return mesh_.positions[static_cast<std::size_t>(corners_[k % n].vertex)];
    };
    Vec3<double> normal{};
    for (std::size_t k = 2; k < n; ++k)
      normal += cross(position(k - 1) - position(0), position(k) - position(0));
    std::size_t best = 0;
    double best_angle = 0;
    for (std::size_t root = 0; root < n; ++root) {
      double angle = std::numeric_limits<double>::infinity();
      for (std::size_t k = 2; k < n; ++k)
        angle = std::min(
            angle, least_angle(position(root), position(root + k - 1), position(root + k), normal));
      // Rounding alone must not turn the diagonals of a regular mesh this way and that.
      if (root > 0 && !(angle > best_angle + 1e-6)) continue;
      best = root;
      best_angle = angle;
    }
    std::rotate(corners_.begin(), corners_.begin() + static_cast<std::ptrdiff_t>(best),
                corners_.end());
  }

  /// The most specific of object, group and material names a face: o < g < usemtl.
  void read_group(std::string_view keyword, std::string_view rest) {
    const std::size_t level = keyword == "o" ? 0 : keyword == "g" ? 1 : 2;
    const std::string_view name = next_word(rest);
    names_[level] = without_controls(std::string(name));  // messages show names
    for (std::size_t k = level + 1; k < 2; ++k) names_[k].clear();
    with_materials_ = with_materials_ || !names_[2].empty();
    with_groups_ = with_groups_ || (level == 1 && !names_[1].empty());
    if (level == 0) objects_.name_next(one_line(names_[0]), mesh_.triangles.size());
    if (level < 2)
      parts_.name_next(one_line(names_[1].empty() ? names_[0] : names_[1]), mesh_.triangles.size());
    const std::string& chosen = !names_[2].empty()   ? names_[2]
                                : !names_[1].empty() ? names_[1]
                                                     : names_[0];
    groups_.name_next(one_line(chosen), mesh_.triangles.size());
  }

  /// ARCSim's label of the face before it.
  void read_label(std::string_view keyword, std::string_view rest) {
    const std::string_view word = next_word(rest);
    long long label = 0;
    if (!parse_number(word, label)) refuse(std::string(keyword), word, "a whole number");
    if (mesh_.triangles.empty()) refuse(std::string(keyword), word, "a face before its label");
    const Index before = groups_.now();
    groups_.name_next("label_" + std::to_string(label), mesh_.triangles.size());
    label_group_ = groups_.now();
    groups_.go_on_with(before);
  }

  /// Puts the last face where its label says. Not at once: of many labels only the last one counts.
  void finish_label() {
    if (label_group_ < 0) return;
    groups_.relabel_from(face_begin_, std::exchange(label_group_, -1));
  }

  /// An object is a group until the group of its first face is named.
  void drop_unused_groups() {
    std::vector<Index> number(mesh_.group_names.size(), -1);
    std::vector<std::string> used;
    for (Index& group : mesh_.group) {
      Index& own = number[static_cast<std::size_t>(group)];
      if (own < 0) {
        own = static_cast<Index>(used.size());
        used.push_back(mesh_.group_names[static_cast<std::size_t>(group)]);
      }
      group = own;
    }
    mesh_.group_names = std::move(used);
  }

  /// A face with texture coordinates at some corners has none.
  void note_textures() {
    const auto textured = static_cast<std::size_t>(std::count_if(
        corners_.begin(), corners_.end(), [](const Corner& c) { return c.texture >= 0; }));
    const bool all = textured == corners_.size();
    const bool mixed = (textured > 0 && !all) || (all ? without_texture_ : with_texture_);
    if (mixed && uv_ == Uv::material)
      refuse("f", all ? "texture coordinates" : "corner without texture coordinate",
             "texture coordinates at all corners of the file or at none");
    (all ? with_texture_ : without_texture_) = true;
    if (all) return;
    for (Corner& corner : corners_) corner.texture = -1;
  }

  /// One pair a vertex where that is all there is to say; else the pairs as the file has them.
  void finish_material() {
    const bool some = with_texture_ && without_texture_ && uv_ == Uv::where_some;
    if (some) mesh_.material = std::move(textures_);
    if (!some && (!with_texture_ || without_texture_)) mesh_.material_triangles.clear();
    if (!with_texture_ || without_texture_) return;
    std::vector<Index> texture_of(mesh_.positions.size(), -1);
    bool seam = false;
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t)
      for (int j = 0; j < 3; ++j) {
        Index& chosen = texture_of[static_cast<std::size_t>(mesh_.triangles[t].v[j])];
        const Index texture = mesh_.material_triangles[t].v[j];
        if (chosen < 0) chosen = texture;
        seam = seam || !(textures_[static_cast<std::size_t>(chosen)] ==
                         textures_[static_cast<std::size_t>(texture)]);
      }
    // A vertex without a face has no pair either; whoever checks the mesh will name it.
    const bool isolated = std::find(texture_of.begin(), texture_of.end(), -1) != texture_of.end();
    if (seam || isolated) {
      mesh_.material = std::move(textures_);
      return;
    }
    mesh_.material_triangles.clear();
    mesh_.material.reserve(mesh_.positions.size());
    for (const Index texture : texture_of)
      mesh_.material.push_back(textures_[static_cast<std::size_t>(texture)]);
  }

  const std::string& file_;
  Uv uv_;
  std::size_t line_number_ = 0;
  std::size_t unknown_count_ = 0;  ///< lines whose keyword is not known
  std::size_t unknown_line_ = 0;   ///< the first of them
  std::string unknown_keyword_;
  Mesh mesh_;
  std::vector<Vec2<double>> textures_;
  std::vector<Corner> corners_;
  std::size_t face_begin_ = 0;  ///< first triangle of the last face
  std::array<std::string, 3> names_;
  FaceLabels groups_;            ///< by the most specific name, or the label of ARCSim
  FaceLabels parts_;             ///< by object and group alone
  FaceLabels objects_;           ///< by object alone
  bool with_materials_ = false;  ///< some face names one
  bool with_groups_ = false;
  std::map<std::string, std::string> panel_labels_;  ///< by the panel's name
  Index label_group_ = -1;                           ///< of the last face; -1: it has no label
  bool with_texture_ = false;                        ///< some face has texture coordinates
  bool without_texture_ = false;                     ///< some face has none
};

}  // namespace

std::string_view next_word(std::string_view& line) {
  const auto is_space = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  std::size_t begin = 0;
  while (begin < line.size() && is_space(line[begin])) ++begin;
  std::size_t end = begin;
  while (end < line.size() && !is_space(line[end])) ++end;
  const std::string_view word = line.substr(begin, end - begin);
  line.remove_prefix(end);
  return word;
}

Mesh parse_obj(std::string_view bytes, const std::string& file, Uv uv,
               std::vector<std::string>* warnings) {
  ObjReader reader(file, uv);
  Mesh mesh = reader.read(bytes);
  if (const std::string warning = reader.warning(); warnings && !warning.empty())
    warnings->push_back(warning);
  return mesh;
}

}  // namespace weft::io
