// What changes of a mesh cost in bending, against the energy of the whole sheet.
#include "host/adaptive/bending_cost.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "host/model/model.hpp"
#include "host/state/energy.hpp"
#include "tests/unit/adaptive/remesh_scenes.hpp"
#include "weft/core/at.hpp"
#include "weft/shapes.hpp"

namespace weft::test {
namespace {

/// A wrinkled sheet whose inner points lie irregularly.
Scene wrinkled_sheet(Bending bending) {
  Scene scene = scene_of({make_grid({1, 1}, {12, 12}, Diagonals::alternating)});
  scene.bending = bending;
  Mesh& mesh = scene.cloths[0].mesh;
  for (std::size_t v = 0; v < mesh.material.size(); ++v) {
    Vec2<double>& u = mesh.material[v];
    if (std::max(std::abs(u[0]), std::abs(u[1])) < 0.499) {
      u[0] += 0.02 * std::sin(7.0 * double(v));
      u[1] += 0.02 * std::sin(11.0 * double(v));
    }
    mesh.positions[v] = {u[0], u[1], 0.05 * std::sin(9 * u[0] + 4 * u[1]) * std::cos(6 * u[1])};
  }
  return scene;
}

SurfaceMesh surface_of(const Mesh& mesh) {
  SurfaceMesh m;
  m.positions = m.starts = mesh.positions;
  m.velocities.assign(m.positions.size(), Vec3<double>{0, 0, 0});
  m.material = mesh.material;
  m.triangles = m.corners = mesh.triangles;
  m.kind.assign(mesh.triangles.size(), 0);
  m.kinds = {{0, 0, -1, 0.2}};
  m.hold.assign(m.positions.size(), 0);
  m.kept.assign(m.positions.size(), 0);
  m.heavy.assign(m.positions.size(), 0);
  for (Index v = 0; v < static_cast<Index>(m.positions.size()); ++v) {
    m.place.push_back(v);
    m.parents.push_back({v, v});
  }
  connect(m);
  m.metric.assign(m.material.size(), Mat2<double>::identity());
  return m;
}

/// Of the sheet that the triangles make which are there; stretching is none.
double bending_of(Scene scene, const SurfaceMesh& m) {
  Mesh& mesh = scene.cloths[0].mesh;
  mesh.triangles.clear();
  std::vector<Index> number(m.positions.size(), -1);
  Mesh now;
  for (std::size_t t = 0; t < m.triangles.size(); ++t) {
    if (m.kind[t] < 0) continue;
    Tri tri = m.triangles[t];
    for (Index& v : tri.v) {
      if (number[at(v)] < 0) {
        number[at(v)] = static_cast<Index>(now.positions.size());
        now.positions.push_back(m.positions[at(v)]);
        now.material.push_back(m.material[at(v)]);
      }
      v = number[at(v)];
    }
    now.triangles.push_back(tri);
  }
  mesh = now;
  const Model model = make_model(scene);
  const std::vector<unsigned char> held(model.area.size(), 0);
  const PlateMatrix plate = make_plate(scene, model, held);
  const double all = measure_energy(scene, model, model.positions, {}, {}, plate).elastic;
  scene.bending = Bending::plate;
  const Model unbent = make_model(scene);
  return all - measure_energy(scene, unbent, unbent.positions, {}).elastic;
}

class BendingCostOf : public testing::TestWithParam<Bending> {};

TEST_P(BendingCostOf, AFlipIsWhatTheSheetGains) {
  const Scene scene = wrinkled_sheet(GetParam());
  const BendingLaws laws = bending_laws(scene);
  const SurfaceMesh before = surface_of(scene.cloths[0].mesh);
  const double was = bending_of(scene, before);
  int looked_at = 0, exact = 0;
  double errors = 0, gains = 0;
  for (Index h = 0; h < static_cast<Index>(before.twin.size()); h += 7) {
    const Index g = before.twin[at(h)];
    if (g < 0) continue;
    SurfaceMesh turned = before;
    flip_edge(turned, h);
    const std::vector<Index> old{h / 3, g / 3};
    std::vector<FreshTriangle> fresh;
    bool valid = true;
    for (const Index t : old) {
      fresh.push_back({turned.triangles[at(t)], turned.corners[at(t)], 0});
      valid = valid && turned.material_det(turned.corners[at(t)]) > 4e-3;
    }
    if (!valid) continue;
    ++looked_at;
    BendingCost cost(before, laws, 0);
    const double gained = bending_of(scene, turned) - was;
    const double error = std::abs(cost.change(fresh, old) - gained);
    exact += error < 1e-3 * std::abs(gained) + 1e-9 * was;
    errors += error;
    gains += std::abs(gained);
  }
  EXPECT_GT(looked_at, 20);
  // A quadratic whose points lie badly, two rings away or farther, may read others after the flip.
  if (GetParam() == Bending::hinge)
    EXPECT_EQ(exact, looked_at);
  else
    EXPECT_GT(exact, 3 * looked_at / 5);
  EXPECT_LT(errors, 0.2 * gains);
}

TEST_P(BendingCostOf, ASplitIsWhatTheSheetGains) {
  const Scene scene = wrinkled_sheet(GetParam());
  const BendingLaws laws = bending_laws(scene);
  const SurfaceMesh before = surface_of(scene.cloths[0].mesh);
  const double was = bending_of(scene, before);
  double errors = 0, gains = 0;
  for (Index h = 0; h < static_cast<Index>(before.twin.size()); h += 11) {
    SurfaceMesh m = before;
    BendingCost cost(m, laws, 0);
    std::vector<Index> touched{h / 3};
    if (m.twin[at(h)] >= 0) touched.push_back(m.twin[at(h)] / 3);
    EXPECT_FALSE(cost.is_slight(cost.hinges_at(touched)));
    const double less = cost.around(touched);
    split_edge(m, h, false, touched);
    cost.forget(touched);
    const double gained = bending_of(scene, m) - was;
    errors += std::abs(cost.around(touched) - less - gained);
    gains += std::abs(gained);
  }
  EXPECT_LT(errors, 0.05 * gains);
}

/// The flips, splits and collapses of a mesh that are valid, one after the other; the energy of
/// each is asked of one that has seen all before and of one that has seen nothing.
TEST_P(BendingCostOf, WhatItHasFoundOutHoldsUntilTheMeshChanges) {
  const Scene scene = wrinkled_sheet(GetParam());
  const BendingLaws laws = bending_laws(scene);
  SurfaceMesh m = surface_of(scene.cloths[0].mesh);
  m.hold[0] = m.hold[1] = m.hold[13] = 1;  // a corner that is held
  BendingCost knows(m, laws, 0);
  int changes = 0, undone = 0;
  const auto expect_same = [](double known, double fresh) {
    EXPECT_NEAR(known, fresh, 1e-12 * (1 + std::abs(fresh)));
  };
  const auto all_valid = [&m](const std::vector<FreshTriangle>& fresh) {
    return std::all_of(fresh.begin(), fresh.end(),
                       [&m](const auto& f) { return m.material_det(f.corner) > 2e-3; });
  };
  for (Index n = 0; n < 400; ++n) {
    const Index h = 37 * n % static_cast<Index>(m.twin.size());
    if (!m.alive(h / 3)) continue;
    if (n % 3 == 0) {
      std::vector<Index> touched{h / 3};
      if (m.twin[at(h)] >= 0) touched.push_back(m.twin[at(h)] / 3);
      expect_same(knows.around(touched), BendingCost(m, laws, 0).around(touched));
      const Index v = split_edge(m, h, false, touched);
      knows.forget(touched);
      expect_same(knows.around(touched), BendingCost(m, laws, 0).around(touched));
      expect_same(knows.hinges_at(touched), BendingCost(m, laws, 0).hinges_at(touched));
      if (n % 2 == 0) {
        undo_split(m, h, v, touched);
        knows.forget(touched);
        ++undone;
      }
      continue;
    }
    std::vector<FreshTriangle> fresh;
    std::vector<Index> old;
    CollapseResult plan;
    if (n % 3 == 1) {
      if (m.is_border(h)) continue;
      const Index g = m.twin[at(h)];
      SurfaceMesh turned = m;
      flip_edge(turned, h);
      old = {h / 3, g / 3};
      for (const Index t : old)
        fresh.push_back({turned.triangles[at(t)], turned.corners[at(t)], turned.kind[at(t)]});
    } else {
      if (!plan_collapse(m, h, plan)) continue;
      old = plan.gone;
      old.insert(old.end(), plan.changed.begin(), plan.changed.end());
      for (std::size_t k = 0; k < plan.changed.size(); ++k)
        fresh.push_back({plan.triangles[k], plan.corners[k], 0});
    }
    if (!all_valid(fresh)) continue;
    expect_same(knows.change(fresh, old), BendingCost(m, laws, 0).change(fresh, old));
    ++changes;
    if (n % 3 == 1)
      flip_edge(m, h);
    else
      collapse_edge(m, h, plan);
    knows.forget(old);
  }
  EXPECT_GT(changes, 50);
  EXPECT_GT(undone, 20);
}

TEST(BendingCost, OfAFlatSheetIsNothing) {
  Scene scene = wrinkled_sheet(Bending::plate);
  for (Vec3<double>& x : scene.cloths[0].mesh.positions) x[2] = 0;
  const BendingLaws laws = bending_laws(scene);
  const SurfaceMesh m = surface_of(scene.cloths[0].mesh);
  BendingCost cost(m, laws, 1e-12);
  EXPECT_TRUE(cost.is_slight(cost.hinges_at({10, 11})));
  EXPECT_NEAR(cost.around({10, 11}), 0, 1e-18);
}

INSTANTIATE_TEST_SUITE_P(Kinds, BendingCostOf, testing::Values(Bending::plate, Bending::hinge));

}  // namespace
}  // namespace weft::test
