#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "host/exec/host_devices.hpp"
#include "tests/unit/collide/brute_force.hpp"
#include "tests/unit/collide/meshes.hpp"
#include "weft/elements/pair_lanes.hpp"
#include "weft/kernels/collide/out_of_bounds.hpp"

namespace weft {
namespace {

using test::brute_force;
using test::BruteForce;
using test::numbers_of;
using test::Pairs;
using test::Points;
using test::Random;

struct Found {
  Pairs face_pairs, edge_pairs;
};

/// @param split_motion [m] 0: any motion is split
template <class T>
Found search(const SweptMesh& mesh, double inflate, double margin, double split_motion,
             int ranks = 1) {
  DeviceSet devices = host_devices(ranks, {true, 0});
  SweptSearch<T> search(devices, mesh, inflate, margin, split_motion);
  search.run();
  return {numbers_of(search.face_pairs()), numbers_of(search.edge_pairs())};
}

bool includes(const Pairs& all, const Pairs& some) {
  return std::includes(all.begin(), all.end(), some.begin(), some.end());
}

/// Crumpled cloth that is carried off, `carried` edges far, turned about its middle by `turn`, and
/// shaken.
SweptMesh carried_sheet(int cells, double carried, double turn, double shake, Random& random) {
  const double edge = 1.0 / cells;
  SweptMesh mesh = test::sheet(cells, edge, 0, random, [&](double x, double y) {
    return Vec3<double>{x, y, 0.1 * std::sin(9 * x)} + random.within(0.2 * edge);
  });
  for (std::size_t v = 0; v < mesh.positions_t0.size(); ++v) {
    const Vec3<double>& x = mesh.positions_t0[v];
    const double a = x[0] - 0.5;
    const double b = x[2];
    mesh.positions_t1[v] = Vec3<double>{0.5 + a * std::cos(turn) - b * std::sin(turn), x[1],
                                        a * std::sin(turn) + b * std::cos(turn)} +
                           carried * edge * Vec3<double>{0.4, -0.3, -1} + random.within(shake);
  }
  return mesh;
}

/// In double with nothing grown: exactly what brute force finds. In float: nothing less.
void expect_brute_force(const SweptMesh& mesh) {
  const BruteForce truth = brute_force(mesh, 0, true);
  for (const int ranks : {1, 3}) {
    const Found exact = search<double>(mesh, 0, 0, 0, ranks);
    EXPECT_EQ(exact.face_pairs, truth.face_pairs);
    EXPECT_EQ(exact.edge_pairs, truth.edge_pairs);
  }
  const Found rounded = search<float>(mesh, 0, 0, 0);
  EXPECT_TRUE(includes(rounded.face_pairs, truth.face_pairs));
  EXPECT_TRUE(includes(rounded.edge_pairs, truth.edge_pairs));
}

TEST(SplitMotion, FindsWhatBruteForceFinds) {
  Random random(41);
  for (const double carried : {0.0, 0.7, 6.0})
    for (const double turn : {0.0, 0.5, 3.0}) {
      SCOPED_TRACE(std::to_string(carried) + " edges, " + std::to_string(turn));
      expect_brute_force(carried_sheet(20, carried, turn, 0.01, random));
    }
}

/// Cloth that moves as a whole lists as many pairs as at rest; its swept boxes would list many
/// times more.
TEST(SplitMotion, CarriedClothListsNoMoreThanAtRest) {
  Random random(42);
  SweptMesh mesh = carried_sheet(40, 5, 0, 0, random);
  const double margin = 0.05 / 40;
  const Found swept = search<float>(mesh, 1e-4, margin, 1);
  const Found split = search<float>(mesh, 1e-4, margin, 0.01);
  mesh.positions_t1 = mesh.positions_t0;
  const Found rest = search<float>(mesh, 1e-4, margin, 0.01);
  const auto size = [](const Pairs& pairs) { return static_cast<double>(pairs.size()); };
  EXPECT_LE(size(split.face_pairs), 1.02 * size(rest.face_pairs));
  EXPECT_LE(size(split.edge_pairs), 1.02 * size(rest.edge_pairs));
  EXPECT_GT(size(swept.face_pairs), 4 * size(rest.face_pairs));
  EXPECT_GT(size(swept.edge_pairs), 4 * size(rest.edge_pairs));
}

/// Short motions are left whole.
TEST(SplitMotion, SplitsOnlyWhatMovesFar) {
  Random random(43);
  const SweptMesh mesh = carried_sheet(16, 2, 0, 0, random);
  const BruteForce whole = brute_force(mesh, 0);
  const BruteForce split = brute_force(mesh, 0, true);
  EXPECT_EQ(search<double>(mesh, 0, 0, 0.126).edge_pairs, whole.edge_pairs);
  EXPECT_EQ(search<double>(mesh, 0, 0, 0.124).edge_pairs, split.edge_pairs);
  EXPECT_LT(2 * split.edge_pairs.size(), whole.edge_pairs.size());
}

/// Distance of a vertex and a face, or of two edges, on straight lines at time t. [m]
template <int First>
double distance_at(const SweptMesh& mesh, const Index (&v)[4], double t) {
  Vec3<double> x[4];
  for (int j = 0; j < 4; ++j) {
    const auto n = static_cast<std::size_t>(v[j]);
    x[j] = (1 - t) * mesh.positions_t0[n] + t * mesh.positions_t1[n];
  }
  return std::sqrt(closest_points<First>(x).distance_sq);
}

template <int First>
bool comes_near(const SweptMesh& mesh, const Index (&v)[4], double reach) {
  constexpr int samples = 24;
  for (int k = 0; k <= samples; ++k)
    if (distance_at<First>(mesh, v, static_cast<double>(k) / samples) <= reach) return true;
  return false;
}

/// All pairs that share no vertex and come as near as `reach` on straight lines, as samples show.
Found near_pairs(const SweptMesh& mesh, double reach) {
  Found found;
  for (Index v = 0; v < mesh.counts.vertices; ++v)
    for (Index f = 0; f < mesh.counts.triangles; ++f) {
      const Index* t = mesh.triangles[static_cast<std::size_t>(f)].v;
      if (t[0] == v || t[1] == v || t[2] == v) continue;
      if (comes_near<1>(mesh, {v, t[0], t[1], t[2]}, reach)) found.face_pairs.emplace_back(v, f);
    }
  for (Index e = 0; e < mesh.counts.edges; ++e)
    for (Index f = e + 1; f < mesh.counts.edges; ++f) {
      const Index* p = mesh.edges[static_cast<std::size_t>(e)].v;
      const Index* q = mesh.edges[static_cast<std::size_t>(f)].v;
      if (p[0] == q[0] || p[0] == q[1] || p[1] == q[0] || p[1] == q[1]) continue;
      if (comes_near<2>(mesh, {p[0], p[1], q[0], q[1]}, reach)) found.edge_pairs.emplace_back(e, f);
    }
  return found;
}

/// Whatever ends in its swept AABB is found if it comes near on the way, however it moves:
/// triangles that fly together, spin, or cross each other.
TEST(SplitMotion, MissesNothingThatComesNear) {
  Random random(44);
  const double reach = 0.004, margin = 0.02;
  for (const std::string kind : {"together", "spinning", "crossing"}) {
    SCOPED_TRACE(kind);
    const SweptMesh mesh = test::soup(50, random, [&](int k, Random& r, auto& x, auto& y) {
      const Vec3<double> at = r.within(0.12);
      for (int j = 0; j < 3; ++j) {
        x[j] = at + r.within(0.1);
        y[j] = x[j] + r.within(0.02);
        if (kind == "together") y[j] += Vec3<double>{0.9, -1.1, 0.3};
        if (kind == "spinning") y[j] = {-x[j][1], x[j][0], x[j][2]};
        if (kind == "crossing") y[j][k % 3] += k % 2 == 0 ? 0.5 : -0.5;
      }
    });
    const Found exact = search<double>(mesh, reach / 2, margin, 0.01);
    const Found rounded = search<float>(mesh, reach / 2, margin, 0.01);
    for (int trial = 0; trial < 3; ++trial) {
      SweptMesh moved = mesh;
      for (Vec3<double>& x : moved.positions_t1) x += random.within(margin);
      const Found truth = near_pairs(moved, reach);
      EXPECT_GT(truth.face_pairs.size(), 10u);
      EXPECT_GT(truth.edge_pairs.size(), 50u);
      EXPECT_TRUE(includes(exact.face_pairs, truth.face_pairs));
      EXPECT_TRUE(includes(exact.edge_pairs, truth.edge_pairs));
      EXPECT_TRUE(includes(rounded.face_pairs, truth.face_pairs));
      EXPECT_TRUE(includes(rounded.edge_pairs, truth.edge_pairs));
    }
  }
}

/// Boxes of obstacles that stand from an earlier search serve searches that split the motion and
/// such that do not, and are recomputed where a vertex moved or has come to rest.
TEST(SplitMotion, ObstaclesThatRestAndThatMove) {
  Random random(45);
  const auto flat = [](double x, double y) { return Vec3<double>{x, y, 0.01 * std::sin(30 * x)}; };
  const SweptMesh cloth = test::sheet(14, 0.05, 0.03, random, flat);
  SweptMesh mesh = test::joined(cloth, test::sheet(11, 0.06, 0, random, flat));
  const auto first = static_cast<std::size_t>(mesh.counts.cloth_vertices);
  DeviceSet devices = host_devices(2, {true, 0});
  SweptSearch<double> search(devices, mesh, 0, 0, 0.05);
  // How far cloth and obstacle move: above 0.05 the motion is split.
  const double cloth_motion[] = {0.01, 0.3, 0.3, 0.3, 0.3, 0.01, 0.01, 0.3, 0.3, 0.01};
  const double obstacle_motion[] = {0, 0, 0.2, 0, 0.2, 0.04, 0, 0, 0.2, 0.04};
  for (std::size_t step = 0; step < std::size(cloth_motion); ++step) {
    mesh.positions_t0 = mesh.positions_t1;
    const Vec3<double> carried{0, 0, step % 2 == 0 ? cloth_motion[step] : -cloth_motion[step]};
    for (std::size_t v = 0; v < mesh.positions_t0.size(); ++v) {
      if (v < first)
        mesh.positions_t1[v] += carried + random.within(0.005);
      else if (step != 4 || v == first + 7)
        mesh.positions_t1[v] += obstacle_motion[step] * Vec3<double>{0.3, 0, 1};
    }
    search.move(mesh.positions_t0, mesh.positions_t1);
    search.run();
    const bool split = std::max(cloth_motion[step], obstacle_motion[step]) > 0.05;
    const BruteForce truth = brute_force(mesh, 0, split);
    EXPECT_EQ(numbers_of(search.face_pairs()), truth.face_pairs) << "step " << step;
    EXPECT_EQ(numbers_of(search.edge_pairs()), truth.edge_pairs) << "step " << step;
  }
}

/// Pairs of a motion that was split serve no other step, wherever its vertices are.
TEST(SplitMotion, ServesOneStep) {
  const DeviceSet devices = host_devices(1, {true, 0});
  Queue& queue = devices[0].compute();
  const std::vector<Vec3<float>> positions(5, Vec3<float>{0.5f, 0.5f, 0.5f});
  const std::vector<Box> boxes(5, Box{{0, 0, 0}, {1, 1, 1}});
  Buffer<Vec3<float>> x(devices[0], 5);
  Buffer<Box> swept_aabb(devices[0], 5);
  Buffer<unsigned char> split(devices[0], 1);
  Buffer<CollideCounts> counts(devices[0], 1);
  queue.copy(x.data(), positions.data(), positions.size() * sizeof positions[0]);
  queue.copy(swept_aabb.data(), boxes.data(), boxes.size() * sizeof boxes[0]);
  for (const bool is_split : {false, true}) {
    queue.fill(split.data(), is_split ? 1 : 0, 1);
    launch(queue, CollideOutOfBounds<float>{x.span(), x.span(), swept_aabb.span(), 0, 5,
                                            counts.span(), split.span()});
    CollideCounts read;
    queue.copy(&read, counts.data(), sizeof read);
    queue.sync();
    EXPECT_EQ(read.out_of_bounds, is_split ? 5 : 0);
  }
}

}  // namespace
}  // namespace weft
