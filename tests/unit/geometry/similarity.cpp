#include "host/geometry/similarity.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "weft/shapes.hpp"

namespace weft {
namespace {

/// The fit must take each point where the placement does, flat sets of points too.
void expect_found(const std::vector<Vec3<double>>& points, const Transform& placement) {
  std::vector<Vec3<double>> moved;
  for (const Vec3<double>& x : points) moved.push_back(apply(placement, x));
  const Similarity fit = fitted_similarity(points, moved);
  EXPECT_NEAR(fit.scale, placement.scale, 1e-12 * placement.scale);
  for (std::size_t i = 0; i < points.size(); ++i)
    EXPECT_LT(length(fit(points[i]) - moved[i]), 1e-11 * (1 + length(moved[i])));
}

TEST(Similarity, IsFoundForSolidsAndPlanes) {
  const auto solid = make_icosphere(0.7, 1).positions;
  const auto plane = make_grid({2, 1}, {2, 2}).positions;
  for (const double angle : {0.0, 1e-9, 0.3, 3.1, 3.141592653589793, -2.0})
    for (const auto& points : {solid, plane}) {
      expect_found(points, {{5, -3, 100}, {0, 0.6, 0.8}, angle, 1});
      expect_found(points, {{0, 0, 0}, {1, 0, 0}, angle, 0.01});
    }
}

TEST(Similarity, OfWhatIsNoneIsNearButMisses) {
  const auto points = make_icosphere(1, 1).positions;
  auto bent = points;
  for (auto& x : bent) x[2] *= 1.5;
  const Similarity fit = fitted_similarity(points, bent);
  double worst = 0;
  for (std::size_t i = 0; i < points.size(); ++i)
    worst = std::max(worst, length(fit(points[i]) - bent[i]));
  EXPECT_GT(worst, 0.1);
  EXPECT_LT(worst, 0.5);
}

}  // namespace
}  // namespace weft
