#include "host/io/pattern/outline_file.hpp"
#include "host/base/file_extension.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "host/base/file_bytes.hpp"
#include "host/io/pattern/edge_curve.hpp"

namespace weft::io {
bool holds_outlines(const std::filesystem::path& file) {
  const std::string extension = lower_extension(file);
  return extension == ".dxf" || extension == ".svg";
}

std::unique_ptr<OutlineFile> open_outlines(const std::filesystem::path& file,
                                           std::optional<double> unit) {
  const std::string bytes = read_file_bytes(file);
  return lower_extension(file) == ".svg" ? parse_svg_outlines(bytes, file.string(), unit)
                                         : parse_dxf_outlines(bytes, file.string(), unit);
}

void centre_outline(PatternPanel& panel) {
  constexpr Index samples = 64;  // of an edge
  Vec2<double> low = panel.vertices.front(), high = low;
  for (const PatternEdge& edge : panel.edges)
    for (const Vec2<double>& p : EdgeCurve(panel, edge).sample(samples))
      for (int k = 0; k < 2; ++k) {
        low[k] = std::min(low[k], p[k]);
        high[k] = std::max(high[k], p[k]);
      }
  const Vec2<double> middle = (low + high) * 0.5;
  for (Vec2<double>& p : panel.vertices) p -= middle;
  for (PatternEdge& edge : panel.edges)
    for (Vec2<double>& p : edge.controls) p -= middle;
  for (Vec2<double>& p : panel.notches) p -= middle;
}

std::optional<double> outline_unit(const std::string& name) {
  constexpr std::array<std::pair<const char*, double>, 4> units{
      {{"m", 1}, {"cm", 0.01}, {"mm", 0.001}, {"in", 0.0254}}};
  for (const auto& [known, metres] : units)
    if (name == known) return metres;
  return {};
}

}  // namespace weft::io
