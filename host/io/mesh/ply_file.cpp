#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <optional>
#include <tuple>

#include "host/geometry/vertex_normals.hpp"
#include "host/input/checker.hpp"
#include "host/input/counted.hpp"
#include "host/input/safe_text.hpp"
#include "host/io/mesh/mesh_formats.hpp"
#include "host/io/mesh/ply_face_labels.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr std::size_t max_elements = 1000;

enum class Type { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

struct TypeName {
  std::string_view name;
  Type type;
};
constexpr std::array<TypeName, 16> type_names{{{"char", Type::int8},
                                               {"int8", Type::int8},
                                               {"uchar", Type::uint8},
                                               {"uint8", Type::uint8},
                                               {"short", Type::int16},
                                               {"int16", Type::int16},
                                               {"ushort", Type::uint16},
                                               {"uint16", Type::uint16},
                                               {"int", Type::int32},
                                               {"int32", Type::int32},
                                               {"uint", Type::uint32},
                                               {"uint32", Type::uint32},
                                               {"float", Type::float32},
                                               {"float32", Type::float32},
                                               {"double", Type::float64},
                                               {"float64", Type::float64}}};

std::size_t size_of(Type type) {
  constexpr std::array<std::size_t, 8> sizes{1, 1, 2, 2, 4, 4, 4, 8};
  return sizes[static_cast<std::size_t>(type)];
}

bool is_real(Type type) {
  return type == Type::float32 || type == Type::float64;
}

struct Property {
  std::string name;
  Type type = Type::float32;
  std::optional<Type> count_type;  ///< a list, if set
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words;
  for (std::string_view word = next_word(line); !word.empty(); word = next_word(line))
    words.push_back(word);
  return words;
}

template <class T>
double load(const char* bytes, bool big_endian) {
  std::array<char, sizeof(T)> own;
  std::memcpy(own.data(), bytes, own.size());
  if (big_endian)
    for (std::size_t k = 0; k < own.size(); ++k) own[k] = bytes[own.size() - 1 - k];
  return static_cast<double>(std::bit_cast<T>(own));
}

double load(const char* bytes, Type type, bool big_endian) {
  switch (type) {
    case Type::int8:
      return load<std::int8_t>(bytes, big_endian);
    case Type::uint8:
      return load<std::uint8_t>(bytes, big_endian);
    case Type::int16:
      return load<std::int16_t>(bytes, big_endian);
    case Type::uint16:
      return load<std::uint16_t>(bytes, big_endian);
    case Type::int32:
      return load<std::int32_t>(bytes, big_endian);
    case Type::uint32:
      return load<std::uint32_t>(bytes, big_endian);
    case Type::float32:
      return load<float>(bytes, big_endian);
    case Type::float64:
      break;
  }
  return load<double>(bytes, big_endian);
}

class PlyReader {
 public:
  PlyReader(std::string_view bytes, const std::string& file, Uv uv)
      : rest_(bytes), file_(file), uv_(uv) {}

  Mesh read() {
    read_header();
    for (const Element& element : elements_) {
      check_count(element);
      if (element.name == "vertex")
        read_vertices(element);
      else
        read_rows(element);
    }
    finish();
    return std::move(mesh_);
  }

 private:
  using Face = PlyFaceLabels::Face;

  [[noreturn]] void refuse(const std::string& field, const std::string& value,
                           const std::string& allowed) const {
    throw SceneError(file_, field, value, allowed);
  }

  std::string_view header_line() {
    const std::size_t end = rest_.find('\n');
    if (end == std::string_view::npos) refuse("header", "end of file", "lines up to end_header");
    const std::string_view line = rest_.substr(0, end);
    rest_.remove_prefix(end + 1);
    return line;
  }

  void read_header() {
    if (words_of(rest_.substr(0, std::min<std::size_t>(rest_.find('\n'), 8))) !=
        std::vector<std::string_view>{"ply"})
      refuse("header", quoted_start(rest_.substr(0, 8)), "\"ply\" as the first line");
    header_line();
    bool has_format = false;
    while (true) {
      const std::string_view line = header_line();
      const std::vector<std::string_view> words = words_of(line);
      if (!words.empty() && words[0] == "comment") labels_.read_comment(words, line);
      if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
      if (words[0] == "end_header") break;
      if (words[0] == "format") {
        read_format(words, line);
        has_format = true;
      } else if (words[0] == "element") {
        read_element(words, line);
      } else if (words[0] == "property") {
        read_property(words, line);
      } else {
        refuse("header", quoted_start(line), "format, comment, element, property, end_header");
      }
    }
    if (!has_format) refuse("header", "no format", "a format line");
  }

  void read_format(const std::vector<std::string_view>& words, std::string_view line) {
    const bool known = words.size() == 3 && words[2] == "1.0" &&
                       (words[1] == "ascii" || words[1] == "binary_little_endian" ||
                        words[1] == "binary_big_endian");
    if (!known)
      refuse("header", quoted_start(line),
             "format ascii, binary_little_endian or binary_big_endian 1.0");
    binary_ = words[1] != "ascii";
    big_endian_ = words[1] == "binary_big_endian";
  }

  void read_element(const std::vector<std::string_view>& words, std::string_view line) {
    long long count = -1;
    if (words.size() != 3 || !parse_number(words[2], count) || count < 0)
      refuse("header", quoted_start(line), "element NAME COUNT");
    if (elements_.size() == max_elements)
      refuse("header", quoted_start(line), "up to " + std::to_string(max_elements) + " elements");
    for (const Element& element : elements_)
      if (element.name == words[1]) refuse("header", quoted_start(line), "each element once");
    elements_.push_back({std::string(words[1]), static_cast<std::uint64_t>(count), {}});
  }

  Type read_type(std::string_view word, std::string_view line) const {
    for (const TypeName& known : type_names)
      if (known.name == word) return known.type;
    refuse("header", quoted_start(line), "char, uchar, short, ushort, int, uint, float, double");
  }

  void read_property(const std::vector<std::string_view>& words, std::string_view line) {
    const bool list = words.size() == 5 && words[1] == "list";
    if (elements_.empty() || (!list && words.size() != 3))
      refuse("header", quoted_start(line), "property TYPE NAME or property list TYPE TYPE NAME");
    Property property;
    property.name = words.back();
    property.type = read_type(words[list ? 3 : 1], line);
    if (list) property.count_type = read_type(words[2], line);
    if (list && is_real(*property.count_type))
      refuse("header", quoted_start(line), "a whole number type for the length of a list");
    elements_.back().properties.push_back(property);
  }

  /// Compares what the header promises with the bytes that are left, before anything is allocated.
  void check_count(const Element& element) const {
    if (element.count == 0) return;
    const std::string field = "element " + quoted_start(element.name);
    const std::string value = counted(element.count, "row");
    if (element.properties.empty()) refuse(field, value + " without properties", "properties");
    std::uint64_t row = 0;
    for (const Property& p : element.properties)
      row += !binary_ ? 2 : size_of(p.count_type ? *p.count_type : p.type);
    // the last line of a text needs no line feed
    const std::uint64_t most = (rest_.size() + (binary_ ? 0 : 1)) / row;
    if (element.count > most || element.count > max_entries)
      refuse(field, value,
             "at most " + std::to_string(std::min<std::uint64_t>(most, max_entries)) +
                 ", which is what the rest of the file can hold");
  }

  double next(Type type, const Element& element, std::uint64_t row) {
    if (binary_) {
      const std::size_t size = size_of(type);
      if (rest_.size() < size) refuse_end(element, row);
      const double value = load(rest_.data(), type, big_endian_);
      rest_.remove_prefix(size);
      return value;
    }
    const std::size_t begin = std::min(rest_.find_first_not_of(" \t\r\n"), rest_.size());
    const std::size_t end = std::min(rest_.find_first_of(" \t\r\n", begin), rest_.size());
    if (begin == end) refuse_end(element, row);
    const std::string_view word = rest_.substr(begin, end - begin);
    rest_.remove_prefix(end);
    double value = 0;
    if (!parse_number(word, value)) refuse(place(element, row), quoted_start(word), "a number");
    return value;
  }

  static std::string place(const Element& element, std::uint64_t row) {
    return "element " + quoted_start(element.name) + " row " + std::to_string(row);
  }
  [[noreturn]] void refuse_end(const Element& element, std::uint64_t row) const {
    refuse(place(element, row), "end of file", counted(element.count, "row"));
  }

  std::size_t next_length(const Property& property, const Element& element, std::uint64_t row) {
    const double length = next(*property.count_type, element, row);
    const double most =
        static_cast<double>(binary_ ? rest_.size() / size_of(property.type) : rest_.size() / 2 + 1);
    if (!(length >= 0 && length <= most) || length != std::floor(length))
      refuse(place(element, row), "a list of length " + text_of(length),
             "a length that the rest of the file can hold");
    return static_cast<std::size_t>(length);
  }

  static int column_of(const std::string& name) {
    constexpr std::array<std::string_view, 3> axes{"x", "y", "z"};
    for (int k = 0; k < 3; ++k)
      if (name == axes[static_cast<std::size_t>(k)]) return k;
    if (name == "s" || name == "u" || name == "texture_u") return 3;
    if (name == "t" || name == "v" || name == "texture_v") return 4;
    return -1;
  }

  void read_vertices(const Element& element) {
    std::array<bool, 5> present{};
    std::vector<int> columns;
    for (const Property& property : element.properties) {
      const int column = property.count_type ? -1 : column_of(property.name);
      columns.push_back(column);
      if (column < 0) continue;
      bool& seen = present[static_cast<std::size_t>(column)];
      if (seen)
        refuse("element \"vertex\"", "property " + quoted_start(property.name) + " again",
               "x, y, z and s, t or u, v once");
      seen = true;
    }
    if (!present[0] || !present[1] || !present[2])
      refuse("element \"vertex\"", "no x, y, z", "properties x, y and z");
    if (present[3] != present[4])
      refuse("element \"vertex\"", "one texture coordinate", "both of s, t or u, v, or none");
    const bool with_material = present[3] && uv_ != Uv::ignore;
    mesh_.positions.reserve(element.count);
    if (with_material) mesh_.material.reserve(element.count);
    for (std::uint64_t row = 0; row < element.count; ++row) {
      std::array<double, 5> n{};
      for (std::size_t p = 0; p < columns.size(); ++p) {
        const Property& property = element.properties[p];
        if (property.count_type) {
          skip_list(property, element, row);
          continue;
        }
        const double value = next(property.type, element, row);
        if (columns[p] < 0) continue;
        if (!std::isfinite(value) && (columns[p] < 3 || with_material))
          refuse(place(element, row) + " " + property.name, std::isnan(value) ? "nan" : "inf",
                 "a finite number");
        n[static_cast<std::size_t>(columns[p])] = value;
      }
      mesh_.positions.push_back({n[0], n[1], n[2]});
      if (with_material) mesh_.material.push_back({n[3], n[4]});
    }
  }

  void skip_list(const Property& property, const Element& element, std::uint64_t row) {
    const std::size_t length = next_length(property, element, row);
    for (std::size_t k = 0; k < length; ++k) next(property.type, element, row);
  }

  /// Faces, and elements that are only walked over.
  void read_rows(const Element& element) {
    const bool faces = element.name == "face";
    const auto is_corners = [&](const Property& p) {
      return faces && p.count_type && (p.name == "vertex_indices" || p.name == "vertex_index");
    };
    if (faces && element.count > 0 &&
        std::count_if(element.properties.begin(), element.properties.end(), is_corners) != 1)
      refuse("element \"face\"", "no vertex_indices", "one property list vertex_indices");
    const auto is_texture = [&](const Property& p) {
      return faces && p.count_type && p.name == "texcoord" && uv_ != Uv::ignore;
    };
    with_wedges_ = with_wedges_ ||
                   std::any_of(element.properties.begin(), element.properties.end(), is_texture);
    for (std::uint64_t row = 0; row < element.count; ++row) {
      Face face;
      for (const Property& property : element.properties) {
        if (is_corners(property))
          read_corners(property, element, row);
        else if (is_texture(property))
          read_texture(property, element, row);
        else if (property.count_type)
          skip_list(property, element, row);
        else if (const double value = next(property.type, element, row); faces)
          labels_.take(property.name, value, face);
      }
      if (faces) add_face(face, element, row);
    }
  }

  void read_corners(const Property& property, const Element& element, std::uint64_t row) {
    const std::size_t length = next_length(property, element, row);
    if (length < 3) refuse(place(element, row), counted(length, "corner"), "at least three");
    if (mesh_.triangles.size() + length > max_entries)
      refuse(place(element, row), "too many triangles", "fewer");
    corners_.clear();
    for (std::size_t k = 0; k < length; ++k) {
      const double number = next(property.type, element, row);
      if (!(number >= 0 && number < static_cast<double>(max_entries)) ||
          number != std::floor(number))
        refuse(place(element, row), "vertex " + text_of(number), "a whole number >= 0");
      corners_.push_back(static_cast<Index>(number));
    }
  }

  /// Texture coordinates of each corner of a face, in single precision as programs write them.
  void read_texture(const Property& property, const Element& element, std::uint64_t row) {
    const std::size_t length = next_length(property, element, row);
    wedges_.clear();
    for (std::size_t k = 0; k < length; ++k) {
      wedges_.push_back(static_cast<float>(next(property.type, element, row)));
      if (!std::isfinite(wedges_.back()))
        refuse(place(element, row) + " texcoord", std::isnan(wedges_.back()) ? "nan" : "inf",
               "a finite number");
    }
  }

  /// Number in `mesh_.material` of the texture coordinates of a corner.
  Index wedge(std::size_t corner) {
    const double u = wedges_[2 * corner], v = wedges_[2 * corner + 1];
    const auto [entry, fresh] = wedge_numbers_.try_emplace(
        std::tuple(corners_[corner], u, v), static_cast<Index>(wedge_coordinates_.size()));
    if (fresh) wedge_coordinates_.push_back({u, v});
    return entry->second;
  }

  void add_face(const Face& face, const Element& element, std::uint64_t row) {
    const bool textured = with_wedges_ && wedges_.size() == 2 * corners_.size();
    if (with_wedges_ && !textured && uv_ == Uv::material)
      refuse(place(element, row) + " texcoord", counted(wedges_.size(), "number"),
             std::to_string(2 * corners_.size()) + ", two for each corner");
    if (!textured) with_wedges_ = false;
    for (std::size_t k = 2; k < corners_.size(); ++k) {
      mesh_.triangles.push_back({{corners_[0], corners_[k - 1], corners_[k]}});
      labels_.add_triangle(face);
      if (textured) wedge_triangles_.push_back({{wedge(0), wedge(k - 1), wedge(k)}});
    }
  }

  /// Texture coordinates of corners, which stand above those of vertices.
  void take_wedges() {
    if (!with_wedges_) return;
    std::vector<Index> first(mesh_.positions.size(), -1);
    bool one_each = wedge_coordinates_.size() == mesh_.positions.size();
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t)
      for (int k = 0; k < 3; ++k) {
        Index& own = first[static_cast<std::size_t>(mesh_.triangles[t].v[k])];
        if (own < 0) own = wedge_triangles_[t].v[k];
        one_each = one_each && own == wedge_triangles_[t].v[k];
      }
    mesh_.material = std::move(wedge_coordinates_);
    if (!one_each) mesh_.material_triangles = std::move(wedge_triangles_);
    if (!one_each) return;
    const std::vector<Vec2<double>> by_wedge = mesh_.material;
    for (std::size_t v = 0; v < first.size(); ++v)
      mesh_.material[v] = by_wedge[static_cast<std::size_t>(first[v])];
  }

  void finish() {
    if (mesh_.positions.empty()) refuse("element \"vertex\"", "no vertices", "at least three");
    if (mesh_.triangles.empty()) refuse("element \"face\"", "no faces", "at least one");
    // Only now, because faces may stand before the vertices.
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t)
      for (const Index v : mesh_.triangles[t].v)
        if (static_cast<std::size_t>(v) >= mesh_.positions.size())
          refuse("element \"face\"",
                 "vertex " + std::to_string(v) + " of triangle " + std::to_string(t),
                 "0 to " + std::to_string(mesh_.positions.size() - 1));
    if (rest_.find_first_not_of(" \t\r\n") != std::string_view::npos)
      refuse("end", std::to_string(rest_.size()) + " bytes after the last element",
             "the elements of the header and nothing else");
    take_wedges();
    labels_.hand_over(mesh_);
  }

  std::string_view rest_;
  const std::string& file_;
  Uv uv_;
  bool binary_ = false;
  bool big_endian_ = false;
  std::vector<Element> elements_;
  Mesh mesh_;
  PlyFaceLabels labels_;
  std::vector<Index> corners_;  ///< of the face at hand
  std::vector<double> wedges_;  ///< [2 corners] of the face at hand
  bool with_wedges_ = false;    ///< all faces so far have texture coordinates of their own
  std::vector<Vec2<double>> wedge_coordinates_;
  std::vector<Tri> wedge_triangles_;
  std::map<std::tuple<Index, double, double>, Index> wedge_numbers_;  ///< by vertex, u, v
};

template <class T>
void append(std::string& bytes, T value) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  bytes.append(raw, sizeof(T));
}

void append_real(std::string& bytes, double value, Precision precision) {
  if (precision == Precision::double_precision)
    append(bytes, value);
  else
    append(bytes, static_cast<float>(value));
}

/// Texture coordinates of the corners of a triangle; (0, 0) for a mesh without.
void append_wedges(std::string& bytes, const Mesh& mesh, std::size_t triangle) {
  const auto& corners = mesh.material_triangles.empty() ? mesh.triangles : mesh.material_triangles;
  append(bytes, std::uint8_t{6});
  for (const Index v : corners[triangle].v)
    for (int k = 0; k < 2; ++k)
      append(bytes, mesh.material.empty()
                        ? 0.0F
                        : static_cast<float>(mesh.material[static_cast<std::size_t>(v)][k]));
}

}  // namespace

Mesh parse_ply(std::string_view bytes, const std::string& file, Uv uv) {
  return PlyReader(bytes, file, uv).read();
}

std::string format_ply(const std::vector<NamedMesh>& meshes, Precision precision, Normals normals,
                       const SeamEdges& seams) {
  std::size_t vertices = 0, triangles = 0, edges = 0;
  bool with_material = true;  // of every mesh
  bool with_wedges = false;   // some vertex has several
  for (const NamedMesh& named : meshes) {
    vertices += named.mesh.positions.size();
    triangles += named.mesh.triangles.size();
    with_material = with_material && !named.mesh.material.empty();
    with_wedges = with_wedges || !named.mesh.material_triangles.empty();
  }
  for (const auto& own : seams) edges += own.size();
  with_wedges = with_wedges && std::any_of(meshes.begin(), meshes.end(), [](const NamedMesh& m) {
                  return !m.mesh.material.empty();
                });
  with_material = with_material && !with_wedges;
  const PlyPanels panels(meshes);
  const std::string real = precision == Precision::double_precision ? "double" : "float";
  std::string bytes = "ply\nformat binary_little_endian 1.0\n" + panels.comments() +
                      "element vertex " + std::to_string(vertices) + "\n";
  for (const char* axis : {"x", "y", "z"}) bytes += "property " + real + " " + axis + "\n";
  if (normals == Normals::vertex)
    for (const char* axis : {"nx", "ny", "nz"})
      bytes += std::string("property float ") + axis + "\n";
  if (with_material)
    for (const char* axis : {"s", "t"}) bytes += "property " + real + " " + axis + "\n";
  bytes +=
      "element face " + std::to_string(triangles) + "\nproperty list uchar int vertex_indices\n";
  if (with_wedges) bytes += "property list uchar float texcoord\n";
  bytes += panels.properties();
  if (edges > 0)
    bytes +=
        "element edge " + std::to_string(edges) + "\nproperty int vertex1\nproperty int vertex2\n";
  bytes += "end_header\n";
  bytes.reserve(bytes.size() + vertices * 52 + triangles * 13);
  for (const NamedMesh& named : meshes) {
    const auto directions =
        normals == Normals::vertex ? vertex_normals(named.mesh) : std::vector<Vec3<float>>();
    for (std::size_t v = 0; v < named.mesh.positions.size(); ++v) {
      for (int k = 0; k < 3; ++k) append_real(bytes, named.mesh.positions[v][k], precision);
      if (!directions.empty())
        for (int k = 0; k < 3; ++k) append(bytes, directions[v][k]);
      if (!with_material) continue;
      for (int k = 0; k < 2; ++k) append_real(bytes, named.mesh.material[v][k], precision);
    }
  }
  Index first = 0;
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    const Mesh& mesh = meshes[m].mesh;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      append(bytes, std::uint8_t{3});
      for (const Index v : mesh.triangles[t].v) append(bytes, static_cast<std::int32_t>(first + v));
      if (with_wedges) append_wedges(bytes, mesh, t);
      panels.append_row(bytes, m, t);
    }
    first += static_cast<Index>(mesh.positions.size());
  }
  first = 0;
  for (std::size_t m = 0; m < seams.size(); ++m) {
    for (const auto& edge : seams[m])
      for (const Index v : edge) append(bytes, static_cast<std::int32_t>(first + v));
    first += static_cast<Index>(meshes[m].mesh.positions.size());
  }
  return bytes;
}

}  // namespace weft::io
