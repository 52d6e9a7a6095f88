#include "host/lab/worn/waist.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <numeric>
#include <utility>
#include <vector>

#include "host/lab/worn/body_figure.hpp"
#include "weft/core/at.hpp"

namespace weft::lab {
namespace {

/// Of the way from the crotch, near which a section may be that of one thigh, to the shoulders.
constexpr double lower_share = 0.3, upper_share = 0.75;
constexpr int sections = 40;

/// Where a plane cuts a triangle.
struct Cut {
  double length = 0;           ///< [m]
  Vec3<double> middle;         ///< [m]
  std::size_t edges[2]{0, 0};  ///< that it cuts, numbered in the section
};

/// Length of the loop of a section that is nearest to a point; infinite without any.
/// @param height [m] along up
double loop_length(const Mesh& body, const Vec3<double>& up, double height,
                   const Vec3<double>& near) {
  std::map<std::pair<Index, Index>, std::size_t> number;
  std::vector<Cut> cuts;
  for (const Tri& t : body.triangles) {
    Cut cut;
    Vec3<double> ends[2];
    int count = 0;
    for (int k = 0; k < 3; ++k) {
      const Index a = t.v[k], b = t.v[(k + 1) % 3];
      const Vec3<double>&x = body.positions[at(a)], &y = body.positions[at(b)];
      const double below = dot(x, up) - height, above = dot(y, up) - height;
      if ((below < 0) == (above < 0) || count == 2) continue;
      cut.edges[count] = number.try_emplace(std::minmax(a, b), number.size()).first->second;
      ends[count++] = x + (below / (below - above)) * (y - x);
    }
    if (count < 2) continue;
    cut.length = length(ends[1] - ends[0]);
    cut.middle = 0.5 * (ends[0] + ends[1]);
    cuts.push_back(cut);
  }
  std::vector<std::size_t> parent(number.size());
  std::iota(parent.begin(), parent.end(), std::size_t{0});
  const auto root = [&](std::size_t e) {
    while (parent[e] != e) e = parent[e] = parent[parent[e]];
    return e;
  };
  for (const Cut& cut : cuts) parent[root(cut.edges[0])] = root(cut.edges[1]);
  std::map<std::size_t, std::pair<double, Vec3<double>>> loops;  // length, and sum of middles
  for (const Cut& cut : cuts) {
    auto& [sum, middles] =
        loops.try_emplace(root(cut.edges[0]), 0.0, Vec3<double>{0, 0, 0}).first->second;
    sum += cut.length;
    middles += cut.length * cut.middle;
  }
  double nearest = std::numeric_limits<double>::infinity(), found = nearest;
  for (const auto& [edge, loop] : loops) {
    if (!(loop.first > 0)) continue;
    const double away = length_sq((1 / loop.first) * loop.second - near);
    if (away < nearest) {
      nearest = away;
      found = loop.first;
    }
  }
  return found;
}

}  // namespace

std::optional<Waist> find_waist(const Mesh& body, const Vec3<double>& up) {
  const BodyFigure figure(body, up);
  if (!figure.has_limbs()) return {};
  const BodyLines lines = figure.lines(body.positions);
  const auto& trunk = lines.line[static_cast<std::size_t>(BodyPart::trunk)];
  const auto& arm = lines.line[static_cast<std::size_t>(BodyPart::first_arm)];
  if (trunk.empty() || arm.empty()) return {};
  const double low = dot(trunk.back(), up), high = dot(arm.front(), up);
  double least = std::numeric_limits<double>::infinity();
  Waist waist{0, figure.height()};
  for (int k = 0; k <= sections; ++k) {
    const double share = lower_share + (upper_share - lower_share) * k / sections;
    const double height = low + (high - low) * share;
    const auto nearest =
        std::min_element(trunk.begin(), trunk.end(), [&](const auto& a, const auto& b) {
          return std::abs(dot(a, up) - height) < std::abs(dot(b, up) - height);
        });
    const double around = loop_length(body, up, height, *nearest);
    if (around < least) {
      least = around;
      waist.height = height;
    }
  }
  if (!(least < std::numeric_limits<double>::infinity())) return {};
  return waist;
}

}  // namespace weft::lab
