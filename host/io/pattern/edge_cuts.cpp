#include "host/io/pattern/edge_cuts.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "host/io/pattern/edge_sampling.hpp"
#include "weft/core/at.hpp"

namespace weft::io {
namespace {

/// [m] Largest distance of a notch from the outline. A notch on the cut line is a seam allowance
/// away from the sew line.
constexpr double notch_reach = 0.025;
/// [m] A notch this close to a corner marks the corner.
constexpr double corner_reach = 0.002;

/// [edges] [m] Places of notches along the edges of a panel, increasing.
std::vector<std::vector<double>> notches_along(const PatternPanel& panel,
                                               const std::vector<EdgeCurve>& curves) {
  std::vector<std::vector<double>> along(curves.size());
  for (const Vec2<double>& notch : panel.notches) {
    std::size_t nearest = 0;
    EdgeCurve::Nearest least = curves[0].nearest(notch);
    for (std::size_t e = 1; e < curves.size(); ++e)
      if (const EdgeCurve::Nearest found = curves[e].nearest(notch); found.away < least.away) {
        least = found;
        nearest = e;
      }
    const bool corner =
        least.along < corner_reach || least.along > curves[nearest].length() - corner_reach;
    if (least.away <= notch_reach && !corner) along[nearest].push_back(least.along);
  }
  for (std::vector<double>& of_edge : along) std::sort(of_edge.begin(), of_edge.end());
  return along;
}

/// One side of a stitch, as the stitch runs.
struct Side {
  double length;                ///< [m]
  std::vector<double> notches;  ///< [m] from its beginning
};

Side side_of(const EdgeCurve& curve, std::vector<double> notches, bool reversed) {
  if (reversed) {
    for (double& notch : notches) notch = curve.length() - notch;
    std::reverse(notches.begin(), notches.end());
  }
  return {curve.length(), std::move(notches)};
}

/// [notches + 2] Numbers of the cuts that are put at notches, and of both ends. A notch takes the
/// cut nearest to its mean relative position on the two sides.
std::vector<Index> stops_of(const Side& a, const Side& b, Index parts) {
  std::vector<Index> stops{0};
  const auto count = static_cast<Index>(a.notches.size());
  for (Index k = 0; k < count; ++k) {
    const double share = 0.5 * (a.notches[at(k)] / a.length + b.notches[at(k)] / b.length);
    const auto nearest = static_cast<Index>(std::lround(share * parts));
    stops.push_back(std::clamp(nearest, stops.back() + 1, parts - count + k));
  }
  stops.push_back(parts);
  return stops;
}

/// [m] From the beginning to notch k - 1, or to an end.
double stop_distance(const Side& side, std::size_t k) {
  if (k == 0) return 0;
  return k > side.notches.size() ? side.length : side.notches[k - 1];
}

std::vector<double> distances_of(const Side& side, const std::vector<Index>& stops, bool reversed) {
  std::vector<double> distances{0};
  for (std::size_t k = 1; k < stops.size(); ++k) {
    const double from = stop_distance(side, k - 1), to = stop_distance(side, k);
    const Index parts = stops[k] - stops[k - 1];
    for (Index i = 1; i <= parts; ++i) distances.push_back(from + (to - from) * i / parts);
  }
  if (reversed) {
    for (double& distance : distances) distance = side.length - distance;
    std::reverse(distances.begin(), distances.end());
  }
  return distances;
}

/// Why the notches of two sides cannot meet; empty if they can.
std::string obstacle_to_meeting(const Side& a, const Side& b, Index parts) {
  const std::size_t count = a.notches.size();
  if (count != b.notches.size())
    return std::to_string(count) + " on one side, " + std::to_string(b.notches.size()) +
           " on the other";
  if (static_cast<std::size_t>(parts) <= count) return "they are closer than edges of the mesh";
  for (std::size_t k = 0; k <= count; ++k) {
    const double of_a = stop_distance(a, k + 1) - stop_distance(a, k);
    const double of_b = stop_distance(b, k + 1) - stop_distance(b, k);
    if (!(std::max(of_a, of_b) <= most_gathering * std::min(of_a, of_b)))
      return "the sides between them differ too much in length";
  }
  return "";
}

}  // namespace

EdgeCuts cut_edges(const SewingPattern& pattern, const std::vector<std::vector<EdgeCurve>>& curves,
                   const std::vector<bool>& opposite,
                   const std::vector<std::vector<Index>>& parts) {
  EdgeCuts cuts;
  std::vector<std::vector<std::vector<double>>> notches;
  std::vector<std::vector<int>> stitches_of;
  for (std::size_t p = 0; p < curves.size(); ++p) {
    cuts.distances.emplace_back();
    for (std::size_t e = 0; e < curves[p].size(); ++e)
      cuts.distances[p].push_back(curves[p][e].even_distances(parts[p][e]));
    notches.push_back(notches_along(pattern.panels[p], curves[p]));
    stitches_of.emplace_back(curves[p].size(), 0);
  }
  for (const PatternStitch& stitch : pattern.stitches)
    for (const PatternSide& side : stitch.sides) ++stitches_of[at(side.panel)][at(side.edge)];
  for (std::size_t k = 0; k < pattern.stitches.size(); ++k) {
    const auto& [a, b] = pattern.stitches[k].sides;
    const std::vector<double>& of_a = notches[at(a.panel)][at(a.edge)];
    const std::vector<double>& of_b = notches[at(b.panel)][at(b.edge)];
    const bool alone =
        stitches_of[at(a.panel)][at(a.edge)] == 1 && stitches_of[at(b.panel)][at(b.edge)] == 1;
    if (!alone || of_a.empty() || of_b.empty()) continue;
    const Side first = side_of(curves[at(a.panel)][at(a.edge)], of_a, false);
    const Side second = side_of(curves[at(b.panel)][at(b.edge)], of_b, opposite[k]);
    const Index count = parts[at(a.panel)][at(a.edge)];
    const std::string obstacle = obstacle_to_meeting(first, second, count);
    if (!obstacle.empty()) {
      cuts.notes.push_back("pattern.stitches[" + std::to_string(k) +
                           "]: notches do not meet: " + obstacle);
      continue;
    }
    const std::vector<Index> stops = stops_of(first, second, count);
    cuts.distances[at(a.panel)][at(a.edge)] = distances_of(first, stops, false);
    cuts.distances[at(b.panel)][at(b.edge)] = distances_of(second, stops, opposite[k]);
  }
  return cuts;
}

}  // namespace weft::io
