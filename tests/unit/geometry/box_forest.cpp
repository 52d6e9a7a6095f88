#include "host/geometry/box_forest.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "host/base/random.hpp"

namespace weft {
namespace {

Aabb random_box(std::uint64_t& state) {
  const auto unit = [&] { return (next_random(state) + 1) / 2; };
  const Vec3<double> lo{unit(), unit(), unit()};
  Aabb box;
  box.include(lo, lo + 0.4 * Vec3<double>{unit(), unit(), unit()});
  return box;
}

std::vector<Index> found_in(const BoxForest& forest, const Aabb& box) {
  std::vector<Index> found;
  forest.overlapping(box, [&](Index item) { found.push_back(item); });
  std::sort(found.begin(), found.end());
  return found;
}

std::vector<Index> one_by_one(const std::vector<std::optional<Aabb>>& boxes, const Aabb& box) {
  std::vector<Index> found;
  for (std::size_t i = 0; i < boxes.size(); ++i)
    if (boxes[i] && boxes[i]->overlaps(box)) found.push_back(static_cast<Index>(i));
  return found;
}

double distance(const Aabb& box, const Vec3<double>& x) {
  Vec3<double> out{};
  for (int c = 0; c < 3; ++c) out[c] = std::max({box.lo[c] - x[c], x[c] - box.hi[c], 0.0});
  return length(out);
}

constexpr double reach = 1.5;

double nearest_of(const std::vector<std::optional<Aabb>>& boxes, const Vec3<double>& x) {
  double nearest = reach;
  for (const std::optional<Aabb>& box : boxes)
    if (box) nearest = std::min(nearest, distance(*box, x));
  return nearest;
}

double nearest_in(const BoxForest& forest, const std::vector<std::optional<Aabb>>& boxes,
                  const Vec3<double>& x) {
  double nearest = reach;
  forest.around(x, reach, [&](Index item) {
    return nearest = std::min(nearest, distance(*boxes[static_cast<std::size_t>(item)], x));
  });
  return nearest;
}

TEST(BoxForest, FindsWhatATestOfEachBoxFindsAfterManyChanges) {
  std::uint64_t state = 7;
  std::vector<Aabb> start;
  std::vector<std::optional<Aabb>> boxes;
  for (int i = 0; i < 120; ++i) {
    // Every fourth is empty: the forest does not have it.
    start.push_back(i % 4 == 3 ? Aabb{} : random_box(state));
    boxes.push_back(i % 4 == 3 ? std::nullopt : std::optional<Aabb>(start.back()));
  }
  BoxForest forest(start);
  std::size_t hits = 0;
  for (int change = 0; change < 2000; ++change) {
    const auto item = static_cast<std::size_t>((next_random(state) + 1) * 75);
    if (boxes.size() <= item) boxes.resize(item + 1);
    const bool replaced = boxes[item].has_value() && next_random(state) < 0;
    const Aabb box = random_box(state);
    if (replaced) {
      forest.replace(static_cast<Index>(item), box);
      boxes[item] = box;
    } else if (boxes[item]) {
      forest.remove(static_cast<Index>(item));
      boxes[item].reset();
    } else {
      forest.insert(static_cast<Index>(item), box);
      boxes[item] = box;
    }
    if (boxes[item]) {
      EXPECT_EQ(forest.box(static_cast<Index>(item)).lo[0], boxes[item]->lo[0]);
    }
    const Aabb asked = random_box(state);
    const std::vector<Index> found = found_in(forest, asked);
    ASSERT_EQ(found, one_by_one(boxes, asked)) << "after change " << change;
    hits += found.size();
    const Vec3<double> x{next_random(state), next_random(state), next_random(state)};
    ASSERT_DOUBLE_EQ(nearest_in(forest, boxes, x), nearest_of(boxes, x))
        << "after change " << change;
  }
  EXPECT_GT(hits, 2000u);
}

TEST(BoxForest, OfNothingFindsNothing) {
  std::uint64_t state = 1;
  EXPECT_TRUE(found_in(BoxForest({}), random_box(state)).empty());
  BoxForest forest({Aabb{}});
  EXPECT_TRUE(found_in(forest, random_box(state)).empty());
  const Aabb box = random_box(state);
  forest.insert(0, box);
  EXPECT_EQ(found_in(forest, box), std::vector<Index>{0});
}

}  // namespace
}  // namespace weft
