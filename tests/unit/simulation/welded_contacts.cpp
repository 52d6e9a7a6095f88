// Welding renumbers vertices, edges and faces; contacts of the last step go on.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "host/implicit/step.hpp"
#include "host/scene/seams/sewing.hpp"
#include "host/state/transfer.hpp"
#include "tests/support/small_scenes.hpp"
#include "weft/core/at.hpp"
#include "weft/shapes.hpp"
#include "weft/simulation.hpp"

namespace weft {
namespace {

/// Two sheets side by side that lie on a plate, and a third on both of them.
Scene on_a_plate() {
  Scene s;
  s.precision = Precision::double_precision;
  s.materials.push_back(test::cotton());
  s.time.step = 0.005;
  s.contact.thickness = 2e-3;
  s.contact.friction = 0.5;
  for (int k = 0; k < 3; ++k) s.cloths.push_back(test::sheet(4, k < 2 ? 2e-3 : 4e-3));
  for (Vec3<double>& x : s.cloths[1].mesh.positions) x[0] += 0.4001;
  for (Vec3<double>& x : s.cloths[2].mesh.positions) x[0] += 0.23;
  Seam seam;
  seam.cloths[1] = 1;
  for (Index j = 0; j <= 4; ++j) {
    seam.vertices[0].push_back(5 * j + 4);
    seam.vertices[1].push_back(5 * j);
  }
  seam.stiffness = 1e-3;
  seam.weld_distance = 2e-3;
  s.seams.push_back(seam);
  Obstacle plate;
  plate.mesh = make_box({2, 2, 0.1}, {1, 1, 1});
  for (Vec3<double>& x : plate.mesh.positions) x[2] -= 0.05;
  plate.friction = 0.5;
  s.obstacles.push_back(plate);
  return s;
}

struct Forces {
  double normal = 0;  ///< [N]
  Vec3<double> friction{};
};

/// Of the contacts of faces, on the plate alone.
Forces on_plate(const Model& model, const StateSnapshot<double>& state) {
  Forces sum;
  for (std::size_t i = 0; i < at(static_cast<Index>(state.face_contacts)); ++i) {
    const ContactMemory<double>& c = state.contacts[i];
    if (c.pair.a >= model.cloth_vertex_count || c.pair.b < model.cloth_triangle_count) continue;
    sum.normal += c.normal_force;
    sum.friction += c.friction;
  }
  return sum;
}

TEST(WeldedContacts, KeepTheirForcesAndTheHistory) {
  Scene s = on_a_plate();
  s.integrator = Integrator::bdf2;
  s.gravity = {1, 0, -9.81};
  DeviceSet devices = host_devices(1);
  Store<double> store(s, devices);
  ImplicitStep<double> step(store);
  for (int n = 0; n < 40; ++n) {
    StepReport report;
    step.advance(s.time.step, report);
    ASSERT_EQ(Failure::none, report.failure);
  }
  const Model& model = store.model();
  const StateSnapshot<double> before = store.snapshot();
  const std::vector<unsigned char> fixed(before.positions.size(), 0);
  const Forces forces = on_plate(model, before);
  ASSERT_GT(forces.normal, 0.5 * 9.81 * model.whole.mass);
  // Edges hold the rest.
  ASSERT_GT(forces.friction[0], 0.5 * model.whole.mass) << "friction holds the sheets";
  for (const Vec3<double>& v : before.velocities) ASSERT_LT(length(v), 1e-4) << "at rest";
  ASSERT_LT(at(static_cast<Index>(before.face_contacts)), before.contacts.size())
      << "no edges meet";

  Store<double> sewn(s, devices, {1, 1, 1, 1, 1}, &store);
  const StateSnapshot<double> merged = merged_state(model, model.tied, fixed, before);
  const StateSnapshot<double> after = transferred(model, merged, {}, sewn.model());
  ASSERT_EQ(model.cloth_vertex_count - 5, sewn.model().cloth_vertex_count);
  const Forces now = on_plate(sewn.model(), after);
  EXPECT_NEAR(forces.normal, now.normal, 1e-12 * forces.normal);
  EXPECT_LT(length(forces.friction - now.friction), 1e-12 * forces.normal);
  EXPECT_EQ(before.previous_step, after.previous_step);

  for (std::size_t i = 0; i < after.contacts.size(); ++i) {
    const ContactMemory<double>& c = after.contacts[i];
    const bool face = i < at(static_cast<Index>(after.face_contacts));
    EXPECT_NEAR(1, length(c.n), 1e-12);
    if (i > 0 && i != at(static_cast<Index>(after.face_contacts))) {
      const Pair& last = after.contacts[i - 1].pair;
      EXPECT_TRUE(last.a < c.pair.a || (last.a == c.pair.a && last.b < c.pair.b)) << i;
    }
    if (face) continue;
    EXPECT_LT(c.pair.a, c.pair.b);
    // Along n lies the way from the second edge to the first.
    const auto middle = [&](Index e) {
      const Edge& edge = sewn.model().edges[at(e)];
      return 0.5 * (after.positions[at(edge.v[0])] + after.positions[at(edge.v[1])]);
    };
    const double above = middle(c.pair.a)[2] - middle(c.pair.b)[2];
    if (std::abs(above) > 1e-3) {
      EXPECT_GT(above * c.n[2], 0) << i;
    }
  }

  // The sheets stay where friction has held them.
  sewn.restore(after);
  ImplicitStep<double> go_on(sewn);
  for (int n = 0; n < 10; ++n) {
    StepReport report;
    go_on.advance(s.time.step, report);
    ASSERT_EQ(Failure::none, report.failure);
  }
  const StateSnapshot<double> last = sewn.snapshot();
  double moved = 0;
  for (Index v = 0; v < sewn.model().cloth_vertex_count; ++v)
    moved = std::max(moved, length(last.positions[at(v)] - after.positions[at(v)]));
  EXPECT_LT(moved, 2e-4);
  const Forces held = on_plate(sewn.model(), last);
  EXPECT_NEAR(held.normal, forces.normal, 0.02 * forces.normal);
}

}  // namespace
}  // namespace weft
