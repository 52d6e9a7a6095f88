#include <array>
#include <charconv>
#include <cstddef>
#include <cstring>
#include <utility>

#include "host/base/parallel.hpp"
#include "host/geometry/vertex_normals.hpp"
#include "host/input/safe_text.hpp"
#include "host/io/mesh/mesh_formats.hpp"

namespace weft::io {
namespace {

/// Text written line by line straight into its storage: numbers are what takes the time.
class TextBuffer {
 public:
  /// @param guess bytes that the text will probably need
  explicit TextBuffer(std::size_t guess) : text_(guess, '\0') {}

  /// Makes room for one line of up to `bytes`.
  void start_line(std::size_t bytes) {
    if (text_.size() - used_ < bytes) text_.resize(std::max(2 * text_.size(), used_ + bytes));
  }
  void add(std::string_view text) {
    std::memcpy(text_.data() + used_, text.data(), text.size());
    used_ += text.size();
  }
  template <class Number>
  void add_number(Number value) {
    char* begin = text_.data() + used_;
    used_ += static_cast<std::size_t>(std::to_chars(begin, text_.data() + text_.size(), value).ptr -
                                      begin);
  }
  template <class T, int N>
  void add_line(std::string_view keyword, const Vec<T, N>& values) {
    start_line(line_max);
    add(keyword);
    for (int k = 0; k < N; ++k) {
      add(" ");
      add_number(values[k]);
    }
    add("\n");
  }
  std::string take() {
    text_.resize(used_);
    return std::move(text_);
  }

  /// No line of numbers is longer: nine whole numbers, or three real ones of 24 characters.
  static constexpr std::size_t line_max = 128;

 private:
  std::string text_;
  std::size_t used_ = 0;
};

/// Numbers of the first vertex (and normal) and texture coordinate of an object.
struct FirstNumbers {
  Index vertex = 1;
  Index texture = 1;
};

/// Lines of `count` items, made by several threads where there are many.
/// @param guess bytes that a line will probably need
/// @param line  called as line(text, i)
template <class Line>
void add_lines(TextBuffer& text, std::size_t count, std::size_t guess, const Line& line) {
  const unsigned threads = setup_threads(count);
  std::vector<std::string> parts(threads);
  on_threads(threads, [&](unsigned n) {
    const std::size_t end = count * (n + 1) / threads;
    std::size_t i = count * n / threads;
    TextBuffer part(guess * (end - i));
    for (; i < end; ++i) line(part, i);
    parts[n] = part.take();
  });
  for (const std::string& part : parts) {
    text.start_line(part.size());
    text.add(part);
  }
}

template <class T, int N>
void add_vectors(TextBuffer& text, std::string_view keyword, const std::vector<Vec<T, N>>& vectors,
                 std::size_t guess) {
  add_lines(text, vectors.size(), guess,
            [&](TextBuffer& part, std::size_t i) { part.add_line(keyword, vectors[i]); });
}

/// A name as one word, since readers take the first one.
std::string obj_word(const std::string& name) {
  std::string word = obj_name(name);
  for (char& c : word)
    if (c == ' ' || c == '#') c = '_';
  return word;
}

/// Lines above the faces of a group; where parts are told apart too, groups are materials, as they
/// are read. With panels, parts alone.
std::string group_lines(const Mesh& mesh, std::size_t t, Groups groups) {
  const auto name_of = [t](const std::vector<Index>& numbers,
                           const std::vector<std::string>& names) {
    return obj_name(names[static_cast<std::size_t>(numbers[t])]) + "\n";
  };
  if (groups == Groups::panels)
    return "g " + obj_word(mesh.part_names[static_cast<std::size_t>(mesh.part[t])]) + "\n";
  const std::string group = name_of(mesh.group, mesh.group_names);
  return mesh.part.empty() ? "g " + group
                           : "g " + name_of(mesh.part, mesh.part_names) + "usemtl " + group;
}

/// A comment for each panel with a label.
void add_panel_labels(TextBuffer& text, const Mesh& mesh) {
  for (std::size_t p = 0; p < mesh.part_labels.size(); ++p) {
    if (mesh.part_labels[p].empty()) continue;
    const std::string line =
        "# panel " + obj_word(mesh.part_names[p]) + " " + obj_word(mesh.part_labels[p]) + "\n";
    text.start_line(line.size());
    text.add(line);
  }
}

void add_seam_edges(TextBuffer& text, const std::vector<std::array<Index, 2>>& edges,
                    Index first_vertex) {
  for (const auto& edge : edges) {
    text.start_line(TextBuffer::line_max);
    text.add("l");
    for (const Index v : edge) {
      text.add(" ");
      text.add_number(first_vertex + v);
    }
    text.add("\n");
  }
}

void add_faces(TextBuffer& text, const Mesh& mesh, FirstNumbers first, bool with_normals,
               Groups groups) {
  const auto& corners_of =
      mesh.material_triangles.empty() ? mesh.triangles : mesh.material_triangles;
  const auto face = [&](TextBuffer& part, std::size_t t) {
    const auto changes = [t](const std::vector<Index>& numbers) {
      return !numbers.empty() && (t == 0 || numbers[t] != numbers[t - 1]);
    };
    if ((groups == Groups::faces && (changes(mesh.group) || changes(mesh.part))) ||
        (groups == Groups::panels && has_panels(mesh) && changes(mesh.part))) {
      const std::string lines = group_lines(mesh, t, groups);
      part.start_line(lines.size());
      part.add(lines);
    }
    part.start_line(TextBuffer::line_max);
    part.add("f");
    for (int k = 0; k < 3; ++k) {
      const Index v = first.vertex + mesh.triangles[t].v[k];
      part.add(" ");
      part.add_number(v);
      if (!mesh.material.empty()) {
        part.add("/");
        part.add_number(first.texture + corners_of[t].v[k]);
      }
      if (!with_normals) continue;
      part.add(mesh.material.empty() ? "//" : "/");
      part.add_number(v);
    }
    part.add("\n");
  };
  add_lines(text, mesh.triangles.size(), with_normals ? 50 : 30, face);
}

}  // namespace

std::string format_obj(const std::vector<NamedMesh>& meshes, Normals normals, Groups groups,
                       const SeamEdges& seams) {
  const bool with_normals = normals == Normals::vertex;
  std::size_t bytes = 0;
  for (const NamedMesh& named : meshes)
    bytes += (with_normals ? 100 : 60) * named.mesh.positions.size() +
             40 * named.mesh.material.size() +
             (with_normals ? 50 : 30) * named.mesh.triangles.size();
  TextBuffer text(bytes);
  FirstNumbers first;
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    const NamedMesh& named = meshes[m];
    const Mesh& mesh = named.mesh;
    if (!named.name.empty()) {
      const std::string name = obj_name(named.name);
      text.start_line(name.size() + 3);
      text.add("o ");
      text.add(name);
      text.add("\n");
    }
    add_vectors(text, "v", mesh.positions, 60);
    add_vectors(text, "vt", mesh.material, 40);
    if (with_normals) add_vectors(text, "vn", vertex_normals(mesh), 40);
    if (groups == Groups::panels) add_panel_labels(text, mesh);
    add_faces(text, mesh, first, with_normals, groups);
    if (m < seams.size()) add_seam_edges(text, seams[m], first.vertex);
    first.vertex += static_cast<Index>(mesh.positions.size());
    first.texture += static_cast<Index>(mesh.material.size());
  }
  return text.take();
}

}  // namespace weft::io
