#include "host/lab/worn/waist.hpp"

#include <gtest/gtest.h>

#include "tests/unit/lab/worn/dressed.hpp"
#include "weft/shapes.hpp"

namespace weft::lab {
namespace {

/// A body of capsules whose trunk is narrowest at a given share of its height.
std::vector<test::Capsule> with_waist(const test::BodyShape& shape, double height) {
  std::vector<test::Capsule> body = test::capsules_of(shape);
  test::Capsule upper = body[0];
  body[0].b = upper.a = {0, 0, height * shape.scale};
  body[0].rb = upper.ra = 0.09 * shape.scale;
  body.push_back(upper);
  return body;
}

TEST(Waist, IsWhereTheTrunkIsNarrowest) {
  for (const double scale : {0.8, 1.0, 1.15})
    for (const double arm : {0.5, 0.8, 1.4})
      for (const double height : {1.08, 1.15}) {
        SCOPED_TRACE(testing::Message() << scale << " " << arm << " " << height);
        test::BodyShape shape;
        shape.scale = scale;
        shape.arm = arm;
        const Mesh body = test::surface_of(with_waist(shape, height), 0.03 * scale);
        const auto waist = find_waist(body, {0, 0, 1});
        ASSERT_TRUE(waist);
        EXPECT_NEAR(waist->height, height * scale, 0.03 * scale);
        EXPECT_NEAR(waist->body_height, 1.73 * scale, 0.1 * scale);
      }
}

TEST(Waist, FollowsTheUpAxis) {
  Mesh body = test::surface_of(with_waist({}, 1.1), 0.03);
  for (Vec3<double>& x : body.positions) x = {x[0], x[2], -x[1]};
  const auto waist = find_waist(body, {0, 1, 0});
  ASSERT_TRUE(waist);
  EXPECT_NEAR(waist->height, 1.1, 0.03);
}

TEST(Waist, BodyWithoutLimbsHasNone) {
  EXPECT_FALSE(find_waist(make_icosphere(1, 3), {0, 0, 1}));
}

}  // namespace
}  // namespace weft::lab
