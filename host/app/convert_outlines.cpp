#include "host/app/convert_outlines.hpp"

#include <fmt/format.h>

#include <cstddef>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>

#include "host/base/atomic_file.hpp"
#include "host/base/file_operations.hpp"
#include "host/input/counted.hpp"
#include "host/input/readable_folders.hpp"
#include "host/input/safe_text.hpp"
#include "host/io/pattern/edge_curve.hpp"
#include "host/io/pattern/outline_file.hpp"
#include "weft/core/at.hpp"
#include "weft/error.hpp"

namespace weft::app {
namespace {

namespace fs = std::filesystem;

void print_panel(const io::PatternPanel& panel) {
  fmt::print("{}: {}{}\n", one_line(panel.name), counted(panel.edges.size(), "edge"),
             panel.grain == Vec2<double>{0, 0} ? "" : ", with a grain line");
  for (std::size_t e = 0; e < panel.edges.size(); ++e) {
    const io::PatternEdge& edge = panel.edges[e];
    const Vec2<double> from = panel.vertices[at(edge.from)], to = panel.vertices[at(edge.to)];
    fmt::print("  {}: ({:.1f}, {:.1f}) to ({:.1f}, {:.1f}) cm, {:.1f} cm long\n", e, 100 * from[0],
               100 * from[1], 100 * to[0], 100 * to[1], 100 * io::EdgeCurve(panel, edge).length());
  }
}

}  // namespace

void convert_outlines(const std::string& input, const std::string& output) {
  const fs::path target = output;
  if (is_there(target)) throw SceneError(output, "OUT", "a file that is there", "a new file");
  ReadableFolders(target).require(input, output, "outlines");
  const std::unique_ptr<io::OutlineFile> outlines = io::open_outlines(input, std::nullopt);
  const std::vector<std::string> names = outlines->names();
  if (names.empty())
    throw SceneError(input, "outlines", "no closed outline with a name", "at least one");
  const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
  nlohmann::json panels = nlohmann::json::object();
  for (const std::string& name : names) {
    io::PatternPanel panel = outlines->panel(name, name);
    centre_outline(panel);
    print_panel(panel);
    panels[name] = {{"label", ""}, {"translation", {0, 0, 0}}, {"rotation", {0, 0, 0}}};
  }
  const nlohmann::json pattern{
      {"pattern",
       {{"outlines", fs::relative(fs::absolute(input), fs::absolute(folder)).generic_string()},
        {"panels", panels},
        {"stitches", nlohmann::json::array()}}},
      {"properties", {{"units_in_meter", 100}}}};
  write_file_atomically(target, pattern.dump(1) + "\n");
  fmt::print("{}: {}; add stitches and places\n", one_line(output), counted(names.size(), "panel"));
}

}  // namespace weft::app
