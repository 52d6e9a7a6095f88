#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "host/exec/host_devices.hpp"
#include "tests/unit/collide/brute_force.hpp"
#include "tests/unit/collide/meshes.hpp"
#include "weft/kernels/collide/out_of_bounds.hpp"

namespace weft {
namespace {

using test::brute_force;
using test::BruteForce;
using test::joined;
using test::numbers_of;
using test::Pairs;
using test::Random;
using test::sheet;
using test::soup;

template <class T>
struct Found {
  Pairs face_pairs, edge_pairs;
  std::vector<std::int64_t> tests;
};

template <class T>
Found<T> search(const SweptMesh& mesh, double inflate, int ranks = 1, double margin = 0) {
  DeviceSet devices = host_devices(ranks, {true, 0});
  SweptSearch<T> search(devices, mesh, inflate, margin);
  search.run();
  return {numbers_of(search.face_pairs()), numbers_of(search.edge_pairs()), search.tests()};
}

void expect_includes(const Pairs& all, const Pairs& some) {
  EXPECT_TRUE(std::includes(all.begin(), all.end(), some.begin(), some.end()));
}

/// In double with nothing grown: exactly what brute force finds, in ascending order. In float:
/// nothing less.
void expect_brute_force(const SweptMesh& mesh) {
  const BruteForce truth = brute_force(mesh, 0);
  const Found<double> exact = search<double>(mesh, 0);
  EXPECT_EQ(exact.face_pairs, truth.face_pairs);
  EXPECT_EQ(exact.edge_pairs, truth.edge_pairs);
  const Found<float> rounded = search<float>(mesh, 0);
  expect_includes(rounded.face_pairs, truth.face_pairs);
  expect_includes(rounded.edge_pairs, truth.edge_pairs);
}

TEST(BroadPhase, CrumpledSheet) {
  Random random(1);
  const SweptMesh mesh = sheet(24, 0.05, 0.04, random, [&](double x, double y) {
    return Vec3<double>{0.4 * x + random.uniform(-0.02, 0.02), y, 0.2 * std::sin(9 * x)};
  });
  expect_brute_force(mesh);
  EXPECT_GT(brute_force(mesh, 0).edge_pairs.size(), 5000u);
}

TEST(BroadPhase, FlatSheetAtRest) {
  Random random(2);
  expect_brute_force(sheet(20, 0.05, 0, random, [](double x, double y) {
    return Vec3<double>{x, y, 0.3};
  }));
}

/// Thousands of pairs in one cell: all boxes meet.
TEST(BroadPhase, EverythingInOneCell) {
  Random random(3);
  const SweptMesh mesh = soup(90, random, [](int, Random& r, auto& x, auto& y) {
    for (int j = 0; j < 3; ++j) {
      x[j] = r.within(0.5);
      y[j] = x[j];
      for (int c = 0; c < 3; ++c) (r.uniform(0, 1) < 0.5 ? x : y)[j][c] *= -1;
    }
  });
  expect_brute_force(mesh);
}

TEST(BroadPhase, HugeAndTinyTogether) {
  Random random(4);
  const SweptMesh mesh = soup(300, random, [](int k, Random& r, auto& x, auto& y) {
    const double size = std::pow(10.0, -6 + k % 9);
    const Vec3<double> centre = r.within(k % 9 < 6 ? 0.01 : 10);
    for (int j = 0; j < 3; ++j) {
      x[j] = centre + r.within(size);
      y[j] = x[j] + r.within(size / 10);
    }
  });
  expect_brute_force(mesh);
}

/// A vertex that flies past all others: its boxes cover any number of cells, the search does not
/// look into more of them than there are boxes.
TEST(BroadPhase, OneThatFliesPastAll) {
  Random random(5);
  SweptMesh mesh = sheet(24, 1e-4, 1e-5, random, [](double x, double y) {
    return Vec3<double>{x, y, 0};
  });
  mesh.positions_t1[100] = {2e6, -1e6, 3e6};
  expect_brute_force(mesh);
}

/// Vertices on one point, triangles without area, edges without length, nothing moves.
TEST(BroadPhase, BoxesWithoutSize) {
  Random random(6);
  const SweptMesh lattice = soup(200, random, [](int k, Random& r, auto& x, auto& y) {
    const Vec3<double> point{std::floor(r.uniform(0, 4)), std::floor(r.uniform(0, 4)), 0};
    for (int j = 0; j < 3; ++j) {
      x[j] = point;
      if (k % 3 == 0 && j == 2) x[j][0] += 1;
      y[j] = x[j];
    }
  });
  expect_brute_force(lattice);
  const SweptMesh point = soup(70, random, [](int, Random&, auto& x, auto& y) {
    for (int j = 0; j < 3; ++j) x[j] = y[j] = {0.1, 0.2, 0.3};
  });
  expect_brute_force(point);
}

/// Boxes that touch in a plane, or miss each other by one unit in the last place.
TEST(BroadPhase, BoxesThatJustTouch) {
  Random random(7);
  const SweptMesh mesh = soup(256, random, [](int k, Random& r, auto& x, auto& y) {
    double low = 0.1 * (k % 16);
    if (k % 5 == 0) low = std::nextafter(low, 1e9);
    const double high = k % 7 == 0 ? std::nextafter(0.1 * (k % 16 + 1), 0.0) : 0.1 * (k % 16 + 1);
    for (int j = 0; j < 3; ++j) {
      x[j] = {j == 0 ? high : low, r.uniform(0, 0.3), r.uniform(0, 0.3)};
      y[j] = x[j];
    }
  });
  expect_brute_force(mesh);
}

TEST(BroadPhase, FarFromTheOrigin) {
  for (const double far : {1e3, 1e6, 1e9}) {
    Random random(8);
    expect_brute_force(sheet(16, 0.05, 0.02, random, [&](double x, double y) {
      return Vec3<double>{far + 0.4 * x, y - far, far + 0.2 * std::sin(9 * x)};
    }));
  }
}

TEST(BroadPhase, GrownBoxes) {
  Random random(9);
  const SweptMesh mesh = sheet(18, 0.05, 0.02, random, [](double x, double y) {
    return Vec3<double>{0.5 * x, y, 0.1 * std::sin(9 * x)};
  });
  for (const double inflate : {1e-12, 1e-3, 0.05, 10.0}) {
    const BruteForce inner = brute_force(mesh, inflate);
    const BruteForce outer = brute_force(mesh, inflate * (1 + 1e-12) + 1e-15);
    const Found<double> found = search<double>(mesh, inflate);
    expect_includes(found.face_pairs, inner.face_pairs);
    expect_includes(found.edge_pairs, inner.edge_pairs);
    expect_includes(outer.face_pairs, found.face_pairs);
    expect_includes(outer.edge_pairs, found.edge_pairs);
    const Found<float> rounded = search<float>(mesh, inflate);
    expect_includes(rounded.face_pairs, inner.face_pairs);
    expect_includes(rounded.edge_pairs, inner.edge_pairs);
  }
}

/// Whatever the vertices do within their swept AABBs, no pair is missing.
TEST(BroadPhase, PairsHoldWithinTheMargin) {
  Random random(10);
  const double margin = 0.01;
  const SweptMesh mesh = sheet(14, 0.05, 0.03, random, [](double x, double y) {
    return Vec3<double>{0.5 * x, y, 0.1 * std::sin(9 * x)};
  });
  const Found<double> found = search<double>(mesh, 0.002, 1, margin);
  EXPECT_GT(found.edge_pairs.size(), search<double>(mesh, 0.002).edge_pairs.size());
  for (int trial = 0; trial < 20; ++trial) {
    SweptMesh moved = mesh;
    for (std::size_t v = 0; v < mesh.positions_t0.size(); ++v) {
      const Vec3<double> u = mesh.positions_t1[v] - mesh.positions_t0[v];
      moved.positions_t0[v] += random.uniform(0, 1) * u + random.within(margin);
      moved.positions_t1[v] += -random.uniform(0, 1) * u + random.within(margin);
    }
    const BruteForce truth = brute_force(moved, 0.002);
    expect_includes(found.face_pairs, truth.face_pairs);
    expect_includes(found.edge_pairs, truth.edge_pairs);
  }
}

TEST(BroadPhase, ObstaclesThatRestAndThatMove) {
  Random random(11);
  const auto flat = [](double x, double y) { return Vec3<double>{x, y, 0.01 * std::sin(30 * x)}; };
  const SweptMesh cloth = sheet(16, 0.05, 0.03, random, flat);
  const SweptMesh obstacle = sheet(13, 0.06, 0, random, flat);
  SweptMesh mesh = joined(cloth, obstacle);
  DeviceSet devices = host_devices(2, {true, 0});
  SweptSearch<double> search(devices, mesh, 0);
  const auto first = static_cast<std::size_t>(mesh.counts.cloth_vertices);
  for (int step = 0; step < 6; ++step) {
    search.run();
    const BruteForce truth = brute_force(mesh, 0);
    EXPECT_EQ(numbers_of(search.face_pairs()), truth.face_pairs) << "step " << step;
    EXPECT_EQ(numbers_of(search.edge_pairs()), truth.edge_pairs) << "step " << step;
    EXPECT_GT(truth.face_pairs.back().first, mesh.counts.cloth_vertices);
    mesh.positions_t0 = mesh.positions_t1;
    for (std::size_t v = 0; v < mesh.positions_t0.size(); ++v) {
      if (v < first) mesh.positions_t1[v] += random.within(0.03);
      // The obstacle rests in steps 1, 2 and 5, and moves, in part or as a whole, in the others.
      if (v >= first && (step == 2 || (step == 3 && v == first + 7)))
        mesh.positions_t1[v] += Vec3<double>{0.02, 0, 0.05};
    }
    search.move(mesh.positions_t0, mesh.positions_t1);
  }
}

/// A sheet of which most lies in a heap.
SweptMesh heap(Random& random) {
  return sheet(40, 0.02, 0.002, random, [&](double x, double y) {
    if (x < 0.5 * y) return Vec3<double>{x, y, 0};
    return Vec3<double>{0.05 * std::sin(40 * x), 0.05 * std::cos(31 * y), 0.02 * (x + y)} +
           random.within(0.01);
  });
}

/// The lists of the ranks, joined, are those of one rank.
template <class T>
void expect_same_for_any_ranks() {
  Random random(12);
  const SweptMesh mesh = heap(random);
  const Found<T> one = search<T>(mesh, 0.001);
  EXPECT_TRUE(std::is_sorted(one.face_pairs.begin(), one.face_pairs.end()));
  EXPECT_TRUE(std::is_sorted(one.edge_pairs.begin(), one.edge_pairs.end()));
  EXPECT_GT(one.edge_pairs.size(), 100000u);
  for (const int ranks : {2, 3, 5, 8}) {
    const Found<T> many = search<T>(mesh, 0.001, ranks);
    EXPECT_EQ(one.face_pairs, many.face_pairs) << ranks << " ranks";
    EXPECT_EQ(one.edge_pairs, many.edge_pairs) << ranks << " ranks";
  }
}

TEST(BroadPhase, SamePairsForAnyNumberOfRanksFloat) {
  expect_same_for_any_ranks<float>();
}
TEST(BroadPhase, SamePairsForAnyNumberOfRanksDouble) {
  expect_same_for_any_ranks<double>();
}

/// A heap in one corner of the numbering: shares of equal size would leave one rank most of it.
TEST(BroadPhase, WorkIsSharedEvenly) {
  Random random(13);
  const SweptMesh mesh = heap(random);
  for (const int ranks : {2, 4}) {
    const std::vector<std::int64_t> tests = search<float>(mesh, 0.001, ranks).tests;
    const double mean =
        static_cast<double>(std::accumulate(tests.begin(), tests.end(), std::int64_t{0})) / ranks;
    EXPECT_LT(static_cast<double>(*std::max_element(tests.begin(), tests.end())), 1.2 * mean)
        << ranks << " ranks";
  }
}

}  // namespace
}  // namespace weft
