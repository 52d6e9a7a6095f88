#include "host/io/pattern/pattern_file.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "host/input/counted.hpp"
#include "host/input/nearest_word.hpp"
#include "host/input/readable_folders.hpp"
#include "host/input/safe_text.hpp"
#include "host/io/json/json_fields.hpp"
#include "host/io/pattern/outline_file.hpp"
#include "weft/core/at.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

using json = nlohmann::json;

constexpr Quantity units_in_meter{"a number", "", 0.01, 1e6};
/// Of panels and their places.
constexpr double largest_coordinate = 100;  // m
constexpr double least_edge = 1e-5;         // m
constexpr std::size_t most_panels = 10'000;
constexpr std::size_t most_corners = 10'000;

/// What all panels have in common.
struct FileSettings {
  double unit = 0.01;            ///< [m] of one unit of the file
  bool relative = true;          ///< curvature is given along and across the chord
  bool centre_vertices = false;  ///< panels turn about the mean of their vertices
};

FileSettings read_properties(Fields& root) {
  FileSettings settings;
  if (!root.has("properties")) return settings;
  Fields fields = root.object("properties", {});
  settings.unit = 1 / fields.number("units_in_meter", units_in_meter, 100);
  settings.relative = fields.choice("curvature_coords", {"relative", "absolute"}, 0) == 0;
  settings.centre_vertices = fields.boolean("normalize_panel_translation", false);
  return settings;
}

/// A point or vector of the file, in metres.
double in_metres(const Fields& fields, const std::string& key, double value, double unit) {
  const double metres = value * unit;
  if (!(std::abs(metres) <= largest_coordinate))
    fields.refuse(key, short_text(value),
                  "a finite length of at most " + short_text(largest_coordinate) + " m, which is " +
                      short_text(largest_coordinate / unit) + " in the units of the file");
  return metres;
}

void read_vertices(Fields& fields, const FileSettings& settings, PatternPanel& panel) {
  const auto given = fields.number_lists("vertices", 2, 2);
  if (given.size() < 2 || given.size() > most_corners)
    fields.refuse("vertices", counted(given.size(), "vertex"),
                  "2 to " + std::to_string(most_corners));
  for (std::size_t k = 0; k < given.size(); ++k) {
    const std::string key = "vertices[" + std::to_string(k) + "]";
    panel.vertices.push_back({in_metres(fields, key, given[k][0], settings.unit),
                              in_metres(fields, key, given[k][1], settings.unit)});
  }
}

/// A control point, in metres.
Vec2<double> control_point(const Fields& fields, const std::vector<double>& given,
                           const FileSettings& settings, const PatternPanel& panel,
                           const PatternEdge& edge) {
  if (!settings.relative)
    return {in_metres(fields, "params", given[0], settings.unit),
            in_metres(fields, "params", given[1], settings.unit)};
  const Vec2<double> from = panel.vertices[at(edge.from)];
  const Vec2<double> along = panel.vertices[at(edge.to)] - from;
  const Vec2<double> across{-along[1], along[0]};
  const Vec2<double> point = from + along * given[0] + across * given[1];
  for (int k = 0; k < 2; ++k)
    if (!(std::abs(point[k]) <= largest_coordinate))
      fields.refuse("params", "a control point within " + short_text(largest_coordinate) + " m");
  return point;
}

void read_arc(Fields& fields, const json& curvature, const FileSettings& settings,
              const PatternPanel& panel, PatternEdge& edge) {
  const auto params = curvature.find("params");
  const auto flag = [](const json& value) {
    return value.is_boolean() ||
           (value.is_number() && (value.get<double>() == 0 || value.get<double>() == 1));
  };
  const auto is_set = [](const json& value) {
    return value.is_boolean() ? value.get<bool>() : value.get<double>() == 1;
  };
  if (params == curvature.end() || !params->is_array() || params->size() != 3 ||
      !(*params)[0].is_number() || !flag((*params)[1]) || !flag((*params)[2]))
    fields.refuse("params", "a radius and two numbers that are 0 or 1: large arc, and turns left");
  edge.shape = PatternEdge::Shape::arc;
  edge.radius = in_metres(fields, "params", (*params)[0].get<double>(), settings.unit);
  edge.large = is_set((*params)[1]);
  edge.left = is_set((*params)[2]);
  const double half = length(panel.vertices[at(edge.to)] - panel.vertices[at(edge.from)]) / 2;
  // Files round their numbers.
  if (!(edge.radius >= half * (1 - 1e-6)))
    fields.refuse(
        "params", short_text((*params)[0]),
        "a radius of at least half the distance of the ends, " + short_text(half / settings.unit));
  edge.radius = std::max(edge.radius, half);
}

void read_bezier(Fields& fields, const std::string& key, std::size_t count,
                 const FileSettings& settings, const PatternPanel& panel, PatternEdge& edge) {
  const auto given = fields.number_lists(key, 2, 2);
  if (given.size() != count)
    fields.refuse(key, counted(given.size(), "point"), std::to_string(count));
  edge.shape = PatternEdge::Shape::bezier;
  for (const std::vector<double>& point : given)
    edge.controls.push_back(control_point(fields, point, settings, panel, edge));
}

void read_curvature(Fields& fields, const json& given, const FileSettings& settings,
                    const PatternPanel& panel, PatternEdge& edge) {
  const json& curvature = given.at("curvature");
  if (curvature.is_null()) return;
  if (curvature.is_array()) {  // the older form: the control point of a quadratic curve
    const Vec2<double> point = fields.vector<2>("curvature");
    edge.shape = PatternEdge::Shape::bezier;
    edge.controls = {control_point(fields, {point[0], point[1]}, settings, panel, edge)};
    return;
  }
  Fields inner = fields.object("curvature", {});
  const std::size_t type = inner.choice("type", {"quadratic", "cubic", "circle"}, {});
  if (type == 2)
    read_arc(inner, curvature, settings, panel, edge);
  else
    read_bezier(inner, "params", type == 0 ? 1 : 2, settings, panel, edge);
}

/// Text that may be missing or null.
std::string optional_text(Fields& fields, const std::string& key) {
  return fields.has(key) && !fields.is_null(key) ? one_line(fields.text(key)) : std::string();
}

void read_edges(Fields& fields, const json& given, const FileSettings& settings,
                PatternPanel& panel) {
  std::vector<Fields> entries = fields.objects("edges", {});
  if (entries.size() < 2 || entries.size() > most_corners)
    fields.refuse("edges", counted(entries.size(), "edge"), "2 to " + std::to_string(most_corners));
  const auto last = static_cast<std::int64_t>(panel.vertices.size()) - 1;
  for (std::size_t k = 0; k < entries.size(); ++k) {
    const auto ends = entries[k].integers("endpoints", 0, last, 2);
    PatternEdge edge;
    edge.from = static_cast<Index>(ends[0]);
    edge.to = static_cast<Index>(ends[1]);
    const double chord = length(panel.vertices[at(edge.to)] - panel.vertices[at(edge.from)]);
    if (!(chord >= least_edge))
      entries[k].refuse("endpoints", short_text(chord / settings.unit) + " apart",
                        "ends that are at least " + short_text(least_edge / settings.unit) +
                            " apart, in the units of the file");
    const json& own = given.at("edges").at(k);
    if (own.contains("curvature")) read_curvature(entries[k], own, settings, panel, edge);
    edge.label = optional_text(entries[k], "label");
    panel.edges.push_back(std::move(edge));
  }
  for (std::size_t k = 0; k < panel.edges.size(); ++k) {
    const std::size_t next = (k + 1) % panel.edges.size();
    if (panel.edges[k].to != panel.edges[next].from)
      entries[next].refuse("endpoints",
                           "an outline that is open: edge " + std::to_string(k) +
                               " ends at vertex " + std::to_string(panel.edges[k].to) + ", edge " +
                               std::to_string(next) + " begins at vertex " +
                               std::to_string(panel.edges[next].from),
                           "edges that each begin where the one before ends");
  }
}

/// What GarmentCode does with "normalize_panel_translation": the origin of the panel goes to the
/// mean of its vertices.
void centre_vertices(PatternPanel& panel) {
  Vec2<double> mean{0, 0};
  for (const Vec2<double>& p : panel.vertices) mean += p;
  mean *= 1.0 / static_cast<double>(panel.vertices.size());
  for (Vec2<double>& p : panel.vertices) p -= mean;
  for (PatternEdge& edge : panel.edges)
    for (Vec2<double>& p : edge.controls) p -= mean;
  panel.translation += Vec3<double>{mean[0], mean[1], 0};
}

/// "outlines": a file of another program with the panels' outlines, beside or below this one.
std::unique_ptr<OutlineFile> read_outlines(Fields& pattern, const std::string& file) {
  if (!pattern.has("outlines")) return nullptr;
  const std::string name = pattern.text("outlines");
  const std::filesystem::path path = std::filesystem::path(file).parent_path() / name;
  if (!holds_outlines(path)) pattern.refuse("outlines", short_text(name), "a file .dxf or .svg");
  ReadableFolders(file).require(path, file, "pattern.outlines");
  std::optional<double> unit;
  if (pattern.has("outlines_unit")) {
    unit = outline_unit(pattern.text("outlines_unit"));
    if (!unit) pattern.refuse("outlines_unit", "m, cm, mm, in");
  }
  return open_outlines(path, unit);
}

/// A panel of "outlines", with its origin in the middle of its bounding box.
PatternPanel outlined_panel(Fields& fields, const OutlineFile& outlines, const std::string& name) {
  PatternPanel panel = outlines.panel(name, "pattern.panels." + one_line(name));
  centre_outline(panel);
  if (!fields.has("edge_labels")) return panel;
  Fields labels = fields.object("edge_labels", {});
  for (const std::string& key : labels.present_keys()) {
    const bool digits =
        !key.empty() && key.size() < 6 && key.find_first_not_of("0123456789") == std::string::npos;
    const std::size_t number = digits ? std::stoul(key) : panel.edges.size();
    if (number >= panel.edges.size())
      fields.refuse("edge_labels", short_text(key),
                    "0 to " + std::to_string(panel.edges.size() - 1) + ", the edges of the panel");
    panel.edges[number].label = one_line(labels.text(key));
  }
  return panel;
}

/// A direction of any length, within reason.
Vec2<double> read_grain(Fields& fields) {
  const Vec2<double> grain = fields.vector<2>("grain");
  if (!(length(grain) >= 1e-6 && length(grain) <= 1e6))
    fields.refuse("grain", "[x, y] with a length of 1e-6 to 1e6");
  return grain;
}

PatternPanel read_panel(Fields& panels, const json& given, const std::string& name,
                        const FileSettings& settings, const OutlineFile* outlines) {
  Fields fields = panels.object(name, {});
  const bool outlined = outlines != nullptr && !fields.has("vertices");
  PatternPanel panel = outlined ? outlined_panel(fields, *outlines, name) : PatternPanel();
  panel.name = one_line(name);
  panel.label = optional_text(fields, "label");
  const Vec3<double> none{0, 0, 0};
  const Vec3<double> translation = fields.vector<3>("translation", none);
  for (int k = 0; k < 3; ++k)
    panel.translation[k] = in_metres(fields, "translation", translation[k], settings.unit);
  panel.rotation = fields.vector<3>("rotation", quantity::angle, none);
  if (fields.has("grain")) panel.grain = read_grain(fields);
  if (outlined) return panel;
  read_vertices(fields, settings, panel);
  read_edges(fields, given, settings, panel);
  if (settings.centre_vertices) centre_vertices(panel);
  return panel;
}

PatternSide read_side(const Fields& pattern, const std::string& place, const json& given,
                      const std::map<std::string, Index>& numbers, const SewingPattern& all) {
  if (!given.is_object())
    pattern.refuse(place, short_text(given), "{\"panel\": ..., \"edge\": ...}");
  const auto panel = given.find("panel");
  if (panel == given.end() || !panel->is_string())
    pattern.refuse(place + ".panel", panel == given.end() ? "missing" : short_text(*panel),
                   "the name of a panel");
  const auto found = numbers.find(panel->get<std::string>());
  if (found == numbers.end())
    pattern.refuse(place + ".panel", short_text(*panel), "the name of a panel of the pattern");
  const auto count = static_cast<std::int64_t>(all.panels[at(found->second)].edges.size());
  const auto edge = given.find("edge");
  const bool whole = edge != given.end() && edge->is_number_integer();
  const std::int64_t number = whole ? edge->get<std::int64_t>() : -1;
  if (number < 0 || number >= count)
    pattern.refuse(
        place + ".edge", edge == given.end() ? "missing" : short_text(*edge),
        "0 to " + std::to_string(count - 1) + ", the edges of panel " + short_text(*panel));
  return {found->second, static_cast<Index>(number)};
}

void read_stitches(Fields& fields, const json& given, const std::map<std::string, Index>& numbers,
                   SewingPattern& pattern) {
  if (!given.contains("stitches") || given.at("stitches").is_null()) return;
  const json& stitches = given.at("stitches");
  if (!stitches.is_array()) fields.refuse("stitches", "a list of stitches");
  std::set<std::array<std::array<Index, 2>, 2>> known;
  for (std::size_t k = 0; k < stitches.size(); ++k) {
    const json& entry = stitches[k];
    const std::string place = "stitches[" + std::to_string(k) + "]";
    const bool marked = entry.is_array() && entry.size() == 3 && entry[2].is_string();
    if (!entry.is_array() || (entry.size() != 2 && !marked))
      fields.refuse(place, short_text(entry), "two sides, or two sides and \"right_wrong\"");
    PatternStitch stitch;
    for (std::size_t side = 0; side < 2; ++side)
      stitch.sides[side] = read_side(fields, place + "[" + std::to_string(side) + "]", entry[side],
                                     numbers, pattern);
    stitch.right_wrong = marked && entry[2].get<std::string>() == "right_wrong";
    const PatternSide &a = stitch.sides[0], &b = stitch.sides[1];
    std::array<std::array<Index, 2>, 2> key{{{a.panel, a.edge}, {b.panel, b.edge}}};
    if (key[1] < key[0]) std::swap(key[0], key[1]);
    if (key[0] == key[1]) fields.refuse(place, short_text(entry), "two different edges");
    if (!known.insert(key).second)
      fields.refuse(place, short_text(entry), "each pair of edges once");
    pattern.stitches.push_back(stitch);
  }
}

/// A line about panels that nothing sews, and about the key that may have been meant to.
void note_missing_stitches(const Fields& fields, SewingPattern& pattern) {
  if (!pattern.stitches.empty()) return;
  std::vector<std::string> others;
  for (const std::string& key : fields.present_keys())
    if (key != "stitches" && key != "panels") others.push_back(key);
  const auto slip = nearest_word("stitches", others);
  if (slip)
    pattern.notes.push_back("pattern." + one_line(*slip) +
                            ": not read, so nothing is sewn; did you mean \"stitches\"?");
  else if (pattern.panels.size() > 1)
    pattern.notes.push_back("pattern.stitches: no stitch, so panels are not sewn");
}

std::string name_of(const std::string& file) {
  std::string stem = std::filesystem::path(file).stem().string();
  const std::string ending = "_specification";
  if (stem.size() > ending.size() && stem.ends_with(ending))
    stem.resize(stem.size() - ending.size());
  return one_line(stem);
}

}  // namespace

bool is_sewing_pattern(const json& document) {
  if (!document.is_object()) return false;
  const auto pattern = document.find("pattern");
  return pattern != document.end() && pattern->is_object() && pattern->contains("panels");
}

bool resembles_sewing_pattern(const json& document) {
  return document.is_object() && (document.contains("pattern") || document.contains("panels"));
}

void require_sewing_pattern(const json& document, const std::string& file) {
  if (is_sewing_pattern(document)) return;
  const std::string allowed =
      "a specification of GarmentCode: {\"pattern\": {\"panels\": ..., \"stitches\": ...}, ...}";
  if (!resembles_sewing_pattern(document)) throw SceneError(file, "pattern", "missing", allowed);
  const auto pattern = document.find("pattern");
  if (pattern == document.end())
    throw SceneError(file, "panels", "outside of \"pattern\"", allowed);
  if (!pattern->is_object()) throw SceneError(file, "pattern", short_text(*pattern), allowed);
  throw SceneError(file, "pattern.panels", "missing", allowed);
}

SewingPattern read_sewing_pattern(const json& document, const std::string& file) {
  SewingPattern pattern;
  pattern.file = file;
  pattern.name = name_of(file);
  json scratch;
  Fields root(document, scratch, pattern.file, "", {});
  const FileSettings settings = read_properties(root);
  if (!document.contains("properties") || !document.at("properties").contains("units_in_meter"))
    pattern.notes.push_back(
        "properties.units_in_meter: missing; lengths are taken for centimetres");
  Fields fields = root.object("pattern", {});
  Fields panels = fields.object("panels", {});
  const json& given = document.at("pattern").at("panels");
  const std::unique_ptr<OutlineFile> outlines = read_outlines(fields, file);
  std::map<std::string, Index> numbers;
  for (const std::string& name : panels.present_keys()) {
    numbers.emplace(name, static_cast<Index>(pattern.panels.size()));
    pattern.panels.push_back(read_panel(panels, given.at(name), name, settings, outlines.get()));
  }
  if (pattern.panels.empty() || pattern.panels.size() > most_panels)
    fields.refuse("panels", counted(pattern.panels.size(), "panel"),
                  "1 to " + std::to_string(most_panels));
  read_stitches(fields, document.at("pattern"), numbers, pattern);
  note_missing_stitches(fields, pattern);
  return pattern;
}

}  // namespace weft::io
