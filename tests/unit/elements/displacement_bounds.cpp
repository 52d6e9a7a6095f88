#include "benchmarks/support/displacement_bounds.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "weft/elements/pair_lanes.hpp"

namespace weft {
namespace {

using bench::DisplacementBounds;

constexpr double separation = 1e-3;
constexpr Index corners[4] = {0, 1, 2, 3};

/// Distance of a random pair whose primitives have gone straight at each other, each by `share` of
/// what its bounds allow.
/// @param bounded whether the bounds allow that
template <int First>
double distance_after(std::mt19937& engine, double share, bool& bounded) {
  std::uniform_real_distribution<double> place(-1, 1);
  Vec3<double> x[4];
  for (auto& corner : x) corner = {place(engine), place(engine), place(engine)};
  const Proximity<double> p = closest_points<First>(x);
  const double distance = std::sqrt(p.distance_sq);
  DisplacementBounds bounds(5);
  bounds.add(corners, distance - separation);
  // Another pair of one corner, with more room: the least counts.
  const Index others[4] = {4, 3, 4, 4};
  bounds.add(others, distance + 1);
  EXPECT_GT(bounds[4], bounds[3]);
  const Vec3<double> n = (1 / distance) * p.difference;
  Vec3<double> moved[4];
  bounded = true;
  for (int j = 0; j < 4; ++j) {
    const auto v = static_cast<std::size_t>(j);
    moved[j] = x[j] + (j < First ? -1.0 : 1.0) * (share * bounds[v]) * n;
    bounded = bounded && bounds.allow(v, x[j], moved[j]);
  }
  return std::sqrt(closest_points<First>(moved).distance_sq);
}

template <int First>
void try_pairs() {
  std::mt19937 engine(7);
  int too_close = 0;
  for (int n = 0; n < 500; ++n) {
    bool bounded = false;
    EXPECT_GE(distance_after<First>(engine, 0.999999, bounded), separation);
    EXPECT_TRUE(bounded);
    // Straight at each other there is nothing to spare.
    too_close += distance_after<First>(engine, 1.0001, bounded) < separation ? 1 : 0;
    EXPECT_FALSE(bounded);
  }
  // Where the closest points stay the same ones.
  EXPECT_GT(too_close, 250);
}

TEST(DisplacementBounds, KeepVerticesAndFacesApart) {
  try_pairs<1>();
}

TEST(DisplacementBounds, KeepEdgesApart) {
  try_pairs<2>();
}

TEST(DisplacementBounds, TouchingPairsAllowNothing) {
  DisplacementBounds bounds(5);
  bounds.add(corners, -1e-9);
  EXPECT_TRUE(bounds.allow(0, Vec3<float>{1, 2, 3}, Vec3<float>{1, 2, 3}));
  EXPECT_FALSE(bounds.allow(0, Vec3<float>{1, 2, 3}, Vec3<float>{1, 2, 3.0001f}));
  EXPECT_FALSE(bounds.allow(0, Vec3<float>{1, 2, 3}, Vec3<float>{1, 2, NAN}));
  // Without pairs anything goes, but what is not a number.
  EXPECT_TRUE(bounds.allow(4, Vec3<float>{}, Vec3<float>{1e6f, 0, 0}));
  EXPECT_FALSE(bounds.allow(4, Vec3<float>{}, Vec3<float>{NAN, 0, 0}));
}

}  // namespace
}  // namespace weft
