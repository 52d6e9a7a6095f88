#include "host/collide/close_pairs.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/unit/collide/meshes.hpp"
#include "weft/elements/pair_lanes.hpp"

namespace weft {
namespace {

using test::Random;

/// Pairs of all kinds: far and near, in one plane, slivers, parallel edges, edges of no length.
std::vector<Vec3<float>> corners(int count, Random& random) {
  std::vector<Vec3<float>> x;
  for (int k = 0; k < count; ++k) {
    const double size = std::pow(10, random.uniform(-3, 0));
    const bool flat = k % 3 == 0;
    Vec3<double> p[4];
    for (Vec3<double>& q : p) {
      q = random.within(size);
      if (flat) q[2] = 0;
    }
    if (k % 5 == 1) p[3] = p[2];
    if (k % 7 == 2) p[1] = p[0];
    if (k % 11 == 3) p[3] = p[2] + (p[1] - p[0]);
    if (k % 13 == 4) p[3] = p[2] + 1e-6 * (p[1] - p[2]);
    const Vec3<double> away = k % 2 == 0 ? Vec3<double>{5, -3, 2} : Vec3<double>{0, 0, 0};
    for (const Vec3<double>& q : p) x.push_back(vec_cast<float>(q + away));
  }
  return x;
}

template <int First>
void expect_bounds() {
  Random random(3);
  constexpr int count = 8 * 400;
  const std::vector<Vec3<float>> x = corners(count, random);
  ClosePairs<float, First> lanes;
  int tight = 0;
  for (Index k = 0; k < count; ++k) {
    lanes.add({static_cast<std::size_t>(k), {4 * k, 4 * k + 1, 4 * k + 2, 4 * k + 3}, 0, 0, 0},
              {x.data(), x.size()});
    if (!lanes.full()) continue;
    float bound[8];
    lanes.distance_bounds(bound);
    for (int lane = 0; lane < 8; ++lane) {
      const Index* v = lanes.item(lane).v;
      Vec3<double> y[4];
      for (int j = 0; j < 4; ++j) y[j] = vec_cast<double>(x[static_cast<std::size_t>(v[j])]);
      const Proximity<double> closest = closest_points<First>(y);
      const double distance = std::sqrt(closest.distance_sq);
      ASSERT_FALSE(std::isnan(bound[lane])) << "pair " << v[0] / 4;
      ASSERT_LE(static_cast<double>(bound[lane]), distance) << "pair " << v[0] / 4;
      if (active_corners(closest) != 0b1111 && static_cast<double>(bound[lane]) > 0.99 * distance)
        ++tight;
    }
    lanes.clear();
  }
  EXPECT_GT(tight, count / 2);
}

TEST(ClosePairs, BoundsOfFacesAreBelowTheDistanceAndMostlyClose) {
  expect_bounds<1>();
}

TEST(ClosePairs, BoundsOfEdgesAreBelowTheDistanceAndMostlyClose) {
  expect_bounds<2>();
}

}  // namespace
}  // namespace weft
