#include "host/io/pattern/edge_sampling.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>

#include "host/io/json/json_fields.hpp"
#include "host/io/pattern/joined_numbers.hpp"
#include "weft/core/at.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

/// Numbers for things that panels have several of.
std::vector<std::size_t> offsets_of(const SewingPattern& pattern, bool corners) {
  std::vector<std::size_t> offsets{0};
  for (const PatternPanel& panel : pattern.panels)
    offsets.push_back(offsets.back() + (corners ? panel.vertices.size() : panel.edges.size()));
  return offsets;
}

void check_gathering(const SewingPattern& pattern, std::size_t stitch, double a, double b) {
  if (std::max(a, b) <= most_gathering * std::min(a, b)) return;
  const PatternStitch& s = pattern.stitches[stitch];
  const auto side = [&](std::size_t k, double length) {
    return field_of(pattern, s.sides[k]) + " of " + short_text(std::round(1e4 * length) / 1e4) +
           " m";
  };
  throw SceneError(pattern.file, "pattern.stitches[" + std::to_string(stitch) + "]",
                   side(0, a) + " sewn to " + side(1, b),
                   "sides of which neither is more than " + short_text(most_gathering) +
                       " times as long as the other");
}

}  // namespace

std::vector<std::vector<EdgeCurve>> edge_curves(const SewingPattern& pattern) {
  std::vector<std::vector<EdgeCurve>> curves;
  for (const PatternPanel& panel : pattern.panels) {
    curves.emplace_back();
    for (const PatternEdge& edge : panel.edges) curves.back().emplace_back(panel, edge);
  }
  return curves;
}

std::vector<std::vector<Index>> edge_parts(const SewingPattern& pattern,
                                           const std::vector<std::vector<EdgeCurve>>& curves,
                                           const std::vector<bool>& opposite, double edge) {
  const std::vector<std::size_t> first_edge = offsets_of(pattern, false);
  const std::vector<std::size_t> first_corner = offsets_of(pattern, true);
  JoinedNumbers edges(first_edge.back()), corners(first_corner.back());
  const auto corner = [&](const PatternSide& side, bool end) {
    const PatternEdge& e = pattern.edge(side);
    return first_corner[at(side.panel)] + at(end ? e.to : e.from);
  };
  for (std::size_t k = 0; k < pattern.stitches.size(); ++k) {
    const auto& [a, b] = pattern.stitches[k].sides;
    check_gathering(pattern, k, curves[at(a.panel)][at(a.edge)].length(),
                    curves[at(b.panel)][at(b.edge)].length());
    edges.join(first_edge[at(a.panel)] + at(a.edge), first_edge[at(b.panel)] + at(b.edge));
    corners.join(corner(a, false), corner(b, opposite[k]));
    corners.join(corner(a, true), corner(b, !opposite[k]));
  }

  struct Size {
    double logarithms = 0;
    int count = 0;
    Index least = 1;
  };
  std::vector<Size> sizes(first_edge.back());
  for (std::size_t p = 0; p < curves.size(); ++p)
    for (std::size_t e = 0; e < curves[p].size(); ++e) {
      Size& size = sizes[edges.find(first_edge[p] + e)];
      size.logarithms += std::log(curves[p][e].length());
      ++size.count;
    }
  const auto parts_of = [&](std::size_t group) {
    const Size& size = sizes[group];
    const double parts = std::round(std::exp(size.logarithms / size.count) / edge);
    return std::max(size.least, static_cast<Index>(std::clamp(parts, 1.0, 1e8)));
  };
  // Edges with the same ends that are not sewn to each other must not become one.
  std::map<std::array<std::size_t, 2>, std::vector<std::size_t>> single;
  for (std::size_t p = 0; p < curves.size(); ++p)
    for (std::size_t e = 0; e < curves[p].size(); ++e) {
      const PatternSide side{static_cast<Index>(p), static_cast<Index>(e)};
      const std::size_t group = edges.find(first_edge[p] + e);
      const auto [a, b] =
          std::minmax({corners.find(corner(side, false)), corners.find(corner(side, true))});
      if (a == b) sizes[group].least = 3;
      std::vector<std::size_t>& others = single[{a, b}];
      if (std::find(others.begin(), others.end(), group) != others.end()) continue;
      others.push_back(group);
      if (others.size() > 1) sizes[group].least = std::max(sizes[group].least, Index{2});
    }
  std::vector<std::vector<Index>> parts;
  for (std::size_t p = 0; p < curves.size(); ++p) {
    parts.emplace_back();
    for (std::size_t e = 0; e < curves[p].size(); ++e)
      parts.back().push_back(parts_of(edges.find(first_edge[p] + e)));
  }
  return parts;
}

}  // namespace weft::io
