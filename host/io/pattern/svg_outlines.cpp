#include <expat.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <memory>
#include <set>
#include <utility>

#include "host/input/counted.hpp"
#include "host/input/safe_text.hpp"
#include "host/io/pattern/outline_file.hpp"
#include "host/io/pattern/svg_path.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

constexpr double pixel = 0.0254 / 96;  // m, of CSS
constexpr std::size_t most_levels = 1000;
constexpr std::size_t most_bytes = 256 << 20;

using Attributes = std::map<std::string, std::string, std::less<>>;

/// An element that draws a line, as it stands in the file.
struct SvgShape {
  std::string name{};
  std::string where{};  ///< file, line and element
  std::string path{};   ///< as an attribute `d`
  SvgTransform transform{};
};

std::string attribute(const Attributes& all, std::string_view name) {
  const auto found = all.find(name);
  return found == all.end() ? std::string() : found->second;
}

/// A length with its unit. @return [m] nothing: no length, or a share of something
std::optional<double> length_of(const std::string& text) {
  const std::map<std::string, double> units{{"", pixel},        {"px", pixel},  {"mm", 0.001},
                                            {"cm", 0.01},       {"in", 0.0254}, {"pt", 0.0254 / 72},
                                            {"pc", 0.0254 / 6}, {"m", 1}};
  const std::size_t end = text.find_last_of("0123456789.");
  if (end == std::string::npos) return {};
  const auto unit = units.find(text.substr(end + 1));
  std::vector<double> value;
  try {
    value = parse_svg_numbers(std::string_view(text).substr(0, end + 1), "", "");
  } catch (const SceneError&) {
    return {};
  }
  if (unit == units.end() || value.size() != 1 || !(value[0] > 0)) return {};
  return value[0] * unit->second;
}

/// Reads the elements of a file.
class SvgReader {
 public:
  SvgReader(std::string_view bytes, const std::string& file) : file_(file) {
    if (bytes.size() > most_bytes)
      throw SceneError(file, "size", std::to_string(bytes.size()) + " bytes", "up to 256 MiB");
    const std::unique_ptr<XML_ParserStruct, void (*)(XML_Parser)> parser(XML_ParserCreate(nullptr),
                                                                         XML_ParserFree);
    parser_ = parser.get();
    XML_SetUserData(parser_, this);
    XML_SetElementHandler(parser_, &SvgReader::begin, &SvgReader::end);
    XML_SetEntityDeclHandler(parser_, &SvgReader::entity);
    const auto status = XML_Parse(parser_, bytes.data(), static_cast<int>(bytes.size()), 1);
    if (failure_) std::rethrow_exception(failure_);
    if (status != XML_STATUS_OK)
      throw SceneError(file, "line " + std::to_string(XML_GetCurrentLineNumber(parser_)),
                       XML_ErrorString(XML_GetErrorCode(parser_)), "an SVG file, which is XML");
    if (!found_svg_) throw SceneError(file, "element", "no svg", "an SVG file");
  }

  std::vector<SvgShape> shapes{};
  /// [m] length of a user unit
  double unit = pixel;

 private:
  /// State of an element that is still open.
  struct Level {
    SvgTransform transform{};
    bool hidden = false;  ///< not drawn where it stands
  };

  // Expat is C: what handlers throw waits until it has returned.
  template <class Work>
  void guarded(const Work& work) {
    if (failure_) return;
    try {
      work();
    } catch (...) {
      failure_ = std::current_exception();
      XML_StopParser(parser_, XML_FALSE);
    }
  }
  static void XMLCALL begin(void* self, const XML_Char* name, const XML_Char** attributes) {
    auto* reader = static_cast<SvgReader*>(self);
    reader->guarded([&] { reader->begin_element(name, attributes); });
  }
  static void XMLCALL end(void* self, const XML_Char*) {
    auto* reader = static_cast<SvgReader*>(self);
    reader->guarded([&] { reader->levels_.pop_back(); });
  }
  static void XMLCALL entity(void* self, const XML_Char*, int, const XML_Char*, int,
                             const XML_Char*, const XML_Char*, const XML_Char*, const XML_Char*) {
    auto* reader = static_cast<SvgReader*>(self);
    reader->guarded(
        [&] { throw SceneError(reader->file_, reader->line(), "an entity declaration", "none"); });
  }

  std::string line() const { return "line " + std::to_string(XML_GetCurrentLineNumber(parser_)); }

  void begin_element(std::string_view name, const XML_Char** given) {
    if (const std::size_t colon = name.find(':'); colon != std::string_view::npos)
      name.remove_prefix(colon + 1);
    Attributes all;
    for (; given[0] != nullptr; given += 2) all.emplace(given[0], given[1]);
    if (levels_.size() >= most_levels)
      throw SceneError(file_, line(), "more than 1000 elements within each other", "fewer");
    Level level = levels_.empty() ? Level{} : levels_.back();
    const std::string where = file_ + ": " + line() + ": " + one_line(name);
    if (name == "svg" && levels_.empty()) {
      found_svg_ = true;
      read_size(all, where);
    }
    constexpr std::array<std::string_view, 7> hiding{"defs",   "symbol",  "clipPath", "mask",
                                                     "marker", "pattern", "metadata"};
    level.hidden = level.hidden || std::find(hiding.begin(), hiding.end(), name) != hiding.end();
    if (const std::string text = attribute(all, "transform"); !text.empty() && !level.hidden)
      level.transform = level.transform.after(parse_svg_transform(text, where));
    if (!level.hidden) add_shape(std::string(name), all, where, level.transform);
    levels_.push_back(level);
  }

  void read_size(const Attributes& all, const std::string& where) {
    const std::string box = attribute(all, "viewBox");
    const auto width = length_of(attribute(all, "width")),
               height = length_of(attribute(all, "height"));
    if (box.empty()) return;
    const std::vector<double> v = parse_svg_numbers(box, where, "viewBox");
    if (v.size() != 4 || !(v[2] > 0) || !(v[3] > 0))
      throw SceneError(where, "viewBox", one_line(box).substr(0, 60),
                       "four numbers, the last two > 0");
    if (width && height)
      unit = std::min(*width / v[2], *height / v[3]);
    else if (width || height)
      unit = width ? *width / v[2] : *height / v[3];
  }

  void add_shape(const std::string& kind, const Attributes& all, const std::string& where,
                 const SvgTransform& transform) {
    std::string path;
    const auto value = [&](const char* name) {
      const std::string text = attribute(all, name);
      return text.empty() ? std::string("0") : text;
    };
    if (kind == "path") {
      path = attribute(all, "d");
    } else if (kind == "polygon" || kind == "polyline") {
      const std::string points = attribute(all, "points");
      if (!points.empty()) path = "M" + points + (kind == "polygon" ? "Z" : "");
    } else if (kind == "rect") {
      for (const char* name : {"x", "y", "width", "height"})
        if (value(name).find_first_not_of("0123456789.+-eE") != std::string::npos) return;
      path = "M" + value("x") + " " + value("y") + "h" + value("width") + "v" + value("height") +
             "h-" + value("width") + "z";
    } else if (kind == "line") {
      path = "M" + value("x1") + " " + value("y1") + "L" + value("x2") + " " + value("y2");
    } else {
      return;
    }
    std::string name = attribute(all, "inkscape:label");
    if (name.empty()) name = attribute(all, "id");
    if (name.empty() || path.empty()) return;
    if (shapes.size() >= 10 * most_outline_panels)
      throw SceneError(where, "shapes with an id", "more than 100000", "fewer");
    name = one_line(name);
    shapes.push_back({name, where + " \"" + name + "\"", std::move(path), transform});
  }

  const std::string& file_;
  XML_Parser parser_ = nullptr;
  std::exception_ptr failure_;
  bool found_svg_ = false;
  std::vector<Level> levels_;
};

class SvgOutlines final : public OutlineFile {
 public:
  SvgOutlines(std::vector<SvgShape> shapes, double unit, std::string file)
      : shapes_(std::move(shapes)), unit_(unit), file_(std::move(file)) {}

  std::vector<std::string> names() const override {
    std::vector<std::string> names;
    std::set<std::string> taken;
    for (const SvgShape& shape : shapes_) {
      const std::vector<SvgSubpath> paths = parse_svg_path(shape.path, shape.where);
      if (paths.size() == 1 && paths.front().closed && taken.insert(shape.name).second)
        names.push_back(shape.name);
    }
    return names;
  }

  PatternPanel panel(const std::string& name, const std::string& field) const override {
    const SvgShape* shape = find(name);
    if (shape == nullptr)
      throw SceneError(file_, field, "no shape of this id or label",
                       "the id, or the label of Inkscape, of a closed path");
    const std::vector<SvgSubpath> paths = parse_svg_path(shape->path, shape->where);
    if (paths.size() != 1)
      throw SceneError(shape->where, "d", counted(paths.size(), "subpath"), "one outline");
    if (!paths.front().closed)
      throw SceneError(shape->where, "d", "an outline that is open",
                       "a path with Z, or one that ends where it begins");
    PatternPanel panel;
    panel.name = name;
    for (const SvgSegment& segment : paths.front().segments) add_edge(*shape, segment, panel);
    if (panel.edges.size() < 2)
      throw SceneError(shape->where, "d", counted(panel.edges.size(), "edge"), "at least 2");
    panel.edges.back().to = 0;
    if (const SvgShape* grain = find(name + "-grain")) {
      const std::vector<SvgSubpath> line = parse_svg_path(grain->path, grain->where);
      if (line.size() != 1 || line[0].segments.empty() || line[0].closed)
        throw SceneError(grain->where, "d", "no line", "one line along the grain");
      panel.grain = placed_at(*grain, line[0].segments.back().to) -
                    placed_at(*grain, line[0].segments.front().from);
    }
    return panel;
  }

 private:
  const SvgShape* find(const std::string& name) const {
    const auto found = std::find_if(shapes_.begin(), shapes_.end(),
                                    [&](const SvgShape& shape) { return shape.name == name; });
    return found == shapes_.end() ? nullptr : &*found;
  }

  /// [m] with y up
  Vec2<double> placed_at(const SvgShape& shape, const Vec2<double>& point) const {
    const Vec2<double> p = shape.transform(point) * unit_;
    if (!(std::abs(p[0]) <= largest_outline_coordinate &&
          std::abs(p[1]) <= largest_outline_coordinate))
      throw SceneError(shape.where, "d", "a coordinate beyond 100 m", "an outline within 100 m");
    return {p[0], -p[1]};
  }

  void add_edge(const SvgShape& shape, const SvgSegment& segment, PatternPanel& panel) const {
    const Vec2<double> from = placed_at(shape, segment.from), to = placed_at(shape, segment.to);
    if (length(to - from) < least_outline_edge) {
      // Some programs end a path with a line to where it already is.
      if (segment.shape == PatternEdge::Shape::line) return;
      throw SceneError(shape.where, "d: edge " + std::to_string(panel.edges.size()),
                       "ends at one place", "ends that are at least 0.01 mm apart");
    }
    if (panel.edges.size() >= most_outline_corners)
      throw SceneError(shape.where, "d",
                       "more than " + std::to_string(most_outline_corners) + " edges", "fewer");
    PatternEdge edge;
    edge.from = static_cast<Index>(panel.vertices.size());
    edge.to = edge.from + 1;
    edge.shape = segment.shape;
    for (const Vec2<double>& control : segment.controls)
      edge.controls.push_back(placed_at(shape, control));
    panel.vertices.push_back(from);
    panel.edges.push_back(std::move(edge));
  }

  std::vector<SvgShape> shapes_;
  double unit_;
  std::string file_;
};

}  // namespace

std::unique_ptr<OutlineFile> parse_svg_outlines(std::string_view bytes, const std::string& file,
                                                std::optional<double> unit) {
  SvgReader reader(bytes, file);
  return std::make_unique<SvgOutlines>(std::move(reader.shapes), unit.value_or(reader.unit), file);
}

}  // namespace weft::io
