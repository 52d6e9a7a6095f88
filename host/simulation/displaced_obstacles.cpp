#include "host/simulation/displaced_obstacles.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace weft {
namespace {

using Positions = std::vector<Vec3<double>>;

/// [thicknesses] A smaller displacement is none. A step that was bisected prescribes positions at a
/// time that may differ from the frame's in its last bit, so places agree to rounding only.
constexpr double displacement_min = 1e-6;
/// Roundings of the largest coordinate that two roundings of one place may differ by.
constexpr double roundings = 4;

Vec3<double> rounded(const Vec3<double>& x, Precision precision) {
  return precision == Precision::single_precision ? vec_cast<double>(vec_cast<float>(x)) : x;
}

double largest_coordinate(const Positions& positions) {
  double largest = 0;
  for (const Vec3<double>& x : positions)
    for (int k = 0; k < 3; ++k) largest = std::max(largest, std::abs(x[k]));
  return largest;
}

}  // namespace

void separate_displaced(const Scene& scene, const Model& model, Frame& frame, Precision precision) {
  std::vector<Vec3<double>> placed;
  place_obstacles(scene, model, frame.time, placed);
  const double epsilon = precision == Precision::single_precision
                             ? static_cast<double>(std::numeric_limits<float>::epsilon())
                             : std::numeric_limits<double>::epsilon();
  frame.displaced_obstacle_positions.assign(scene.obstacles.size(), {});
  for (std::size_t o = 0; o < scene.obstacles.size(); ++o) {
    Positions& simulated = frame.obstacle_positions[o];
    const auto first = placed.begin() + model.obstacle_offset[o];
    Positions prescribed(first, first + static_cast<std::ptrdiff_t>(simulated.size()));
    double distance = 0;
    for (std::size_t v = 0; v < simulated.size(); ++v) {
      prescribed[v] = rounded(prescribed[v], precision);
      distance = std::max(distance, length(simulated[v] - prescribed[v]));
    }
    if (distance <= displacement_min * contact_thickness(scene.contact) +
                        roundings * epsilon * largest_coordinate(simulated))
      continue;
    frame.displaced_obstacle_positions[o] = std::exchange(simulated, std::move(prescribed));
  }
}

}  // namespace weft
