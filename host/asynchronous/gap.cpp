#include "host/asynchronous/gap.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace weft {

double least_gap(const PrimitivePair& pair, const Chord* const corners[4]) {
  Vec3<double> halfway[4];
  for (int c = 0; c < 4; ++c) halfway[c] = (corners[c]->from + corners[c]->to) * 0.5;
  const Proximity<double> closest = pair.closest(halfway);
  constexpr double infinity = std::numeric_limits<double>::infinity();
  if (!(closest.distance_sq > std::numeric_limits<double>::min())) return -infinity;
  const Vec3<double> n = closest.difference * (1 / std::sqrt(closest.distance_sq));
  double first_from = infinity, first_to = infinity, first_deviation = 0;
  double second_from = -infinity, second_to = -infinity, second_deviation = 0;
  for (int c = 0; c < 4; ++c) {
    const double from = dot(n, corners[c]->from), to = dot(n, corners[c]->to);
    if (c < pair.first_count()) {
      first_from = std::min(first_from, from);
      first_to = std::min(first_to, to);
      first_deviation = std::max(first_deviation, corners[c]->deviation);
    } else {
      second_from = std::max(second_from, from);
      second_to = std::max(second_to, to);
      second_deviation = std::max(second_deviation, corners[c]->deviation);
    }
  }
  return std::min(first_from - second_from, first_to - second_to) - first_deviation -
         second_deviation;
}

double most_approach(const PrimitivePair& pair, const Chord* const corners[4]) {
  Vec3<double> way[4], mean{};
  for (int c = 0; c < 4; ++c) {
    way[c] = corners[c]->to - corners[c]->from;
    mean += way[c] * 0.25;
  }
  double most[2] = {0, 0};
  for (int c = 0; c < 4; ++c) {
    double& of = most[c < pair.first_count() ? 0 : 1];
    of = std::max(of, length_sq(way[c] - mean));
  }
  return std::sqrt(most[0]) + std::sqrt(most[1]);
}

}  // namespace weft
