// Tracking constraints in the implicit solve, and motions that are no steps.
#include "host/implicit/tracking/tracking.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

#include "host/implicit/step.hpp"
#include "host/scene/intersection_check.hpp"
#include "host/scene/seams/sewing.hpp"
#include "host/time_parallel/coarse_scene.hpp"
#include "tests/unit/time_parallel/scenes.hpp"
#include "weft/error.hpp"

namespace weft::test {
namespace {

/// A sheet, its coarse level, and a step that may be tied to it.
template <class T>
struct Rig {
  explicit Rig(Scene s) : scene(std::move(s)), level(make_coarse_scene(scene)) {
    scene.method = "implicit";
    store = std::make_unique<Store<T>>(scene, devices);
    step = std::make_unique<ImplicitStep<T>>(*store);
  }
  /// Positions by input numbers.
  std::vector<Vec3<double>> inputs() const {
    const auto state = store->snapshot();
    std::vector<Vec3<double>> result;
    for (const Index v : store->model().to_internal)
      result.push_back(vec_cast<double>(state.positions[static_cast<std::size_t>(v)]));
    return result;
  }
  /// Weighted averages of the tracking's rows, of places by input numbers.
  std::vector<Vec3<double>> averages(const std::vector<Vec3<double>>& places) const {
    const Tracking t = make_tracking(scene, level);
    std::vector<Vec3<double>> result;
    for (std::size_t i = 0; i + 1 < t.offset.size(); ++i) {
      Vec3<double> sum{};
      double total = 0;
      for (auto e = static_cast<std::size_t>(t.offset[i]);
           e < static_cast<std::size_t>(t.offset[i + 1]); ++e) {
        sum += t.weight[e] * places[static_cast<std::size_t>(t.input[e])];
        total += t.weight[e];
      }
      result.push_back((1 / total) * sum);
    }
    return result;
  }
  void tie_to(std::vector<Vec3<double>> places) {
    auto tracking = std::make_shared<Tracking>(make_tracking(scene, level));
    tracking->target = [places = std::move(places)](double) { return places; };
    step->track(tracking);
  }
  StepReport advance() {
    StepReport report;
    step->advance(scene.time.step, report);
    EXPECT_EQ(report.failure, Failure::none) << report.failure_detail;
    return report;
  }

  Scene scene;
  CoarseScene level;
  DeviceSet devices = host_devices(1);
  std::unique_ptr<Store<T>> store;
  std::unique_ptr<ImplicitStep<T>> step;
};

template <class T>
class TrackingSteps : public ::testing::Test {
 protected:
  static constexpr bool single = sizeof(T) == 4;
  static Scene scene() {
    return hanging_sheet(20, single ? Precision::single_precision : Precision::double_precision);
  }
};
using Scalars = ::testing::Types<float, double>;
TYPED_TEST_SUITE(TrackingSteps, Scalars);

TYPED_TEST(TrackingSteps, AveragesStayWhereTheyAreTied) {
  Rig<TypeParam> rig(this->scene());
  const auto start = rig.inputs();
  rig.tie_to(start);
  double error = 0;
  for (int k = 0; k < 10; ++k) error = std::max(error, rig.advance().tracking_error);
  EXPECT_LT(error, this->single ? 1e-6 : 1e-12);
  const auto wanted = rig.averages(start);
  const auto are = rig.averages(rig.inputs());
  std::size_t moved = 0;
  for (std::size_t i = 0; i < wanted.size(); ++i)
    moved += length(are[i] - wanted[i]) > (this->single ? 2e-6 : 1e-11) ? 1 : 0;
  EXPECT_LE(moved, 2u) << "but for the two coarse vertices that are pinned";
  double sag = 0;
  for (std::size_t v = 0; v < start.size(); ++v)
    sag = std::max(sag, length(rig.inputs()[v] - start[v]));
  EXPECT_GT(sag, 1e-4) << "what is finer is free";
}

TYPED_TEST(TrackingSteps, ATargetThatIsTheFreeMotionChangesNothing) {
  Scene scene = this->scene();
  scene.solver.tolerance = this->single ? 1e-5 : 1e-10;
  Rig<TypeParam> free(scene), tied(scene);
  for (int k = 0; k < 5; ++k) {
    free.advance();
    tied.tie_to(free.inputs());
    tied.advance();
  }
  const auto a = free.inputs();
  const auto b = tied.inputs();
  double most = 0;
  for (std::size_t v = 0; v < a.size(); ++v) most = std::max(most, length(a[v] - b[v]));
  EXPECT_LT(most, this->single ? 1e-5 : 1e-9);
}

TYPED_TEST(TrackingSteps, EveryPreconditionerTakesThem) {
  std::vector<std::vector<Vec3<double>>> ends;
  for (const Preconditioner p : {Preconditioner::block_jacobi, Preconditioner::multilevel}) {
    Scene scene = this->scene();
    scene.solver.tolerance = this->single ? 1e-5 : 1e-10;
    scene.solver.preconditioner = p;
    Rig<TypeParam> rig(scene);
    rig.tie_to(rig.inputs());
    for (int k = 0; k < 3; ++k) rig.advance();
    ends.push_back(rig.inputs());
  }
  for (std::size_t p = 1; p < ends.size(); ++p)
    for (std::size_t v = 0; v < ends[p].size(); ++v)
      EXPECT_LT(length(ends[p][v] - ends[0][v]), this->single ? 1e-5 : 1e-9);
}

TYPED_TEST(TrackingSteps, ContactWinsAndTheMissIsReported) {
  Rig<TypeParam> rig(this->scene());
  std::vector<Vec3<double>> below = rig.inputs();
  double most = 0;
  for (int k = 0; k < 12; ++k) {
    for (Vec3<double>& x : below) x[2] -= k < 6 ? 0.01 : 0.04;  // into the ball and beyond
    rig.tie_to(below);
    StepReport report;
    rig.step->advance(rig.scene.time.step, report);
    if (report.failure != Failure::none) break;
    Scene now = rig.scene;
    now.cloths[0].mesh.positions = rig.inputs();
    EXPECT_NO_THROW(refuse_intersecting_start(now)) << "step " << k;
    const auto found = rig.averages(rig.inputs());
    const auto wanted = rig.averages(below);
    std::vector<double> misses;
    for (std::size_t i = 0; i < found.size(); ++i) misses.push_back(length(found[i] - wanted[i]));
    std::sort(misses.begin(), misses.end(), std::greater<>());
    const double miss = misses[2];  // the two coarse vertices that are pinned lag farthest
    EXPECT_NEAR(report.tracking_error, miss, 1e-6) << "step " << k;
    if (k < 6) {
      EXPECT_LT(miss, 1e-6) << "nothing is in the way yet";
    }
    most = std::max(most, miss);
  }
  EXPECT_GT(most, 5e-4);
}

TYPED_TEST(TrackingSteps, MotionsStopAtWhatIsInTheirWay) {
  Rig<TypeParam> rig(this->scene());
  const auto before = rig.store->snapshot();
  std::vector<Vec3<TypeParam>> places(
      before.positions.begin(), before.positions.begin() + rig.store->model().cloth_vertex_count);
  for (auto& x : places) x += Vec3<TypeParam>{TypeParam(0.001), 0, TypeParam(-0.05)};
  StepReport report;
  ASSERT_TRUE(rig.step->displace(places, 0.015, report)) << report.failure_detail;
  EXPECT_GT(report.zones, 0);
  const auto after = rig.store->snapshot();
  EXPECT_EQ(after.time, 0.015);
  std::size_t there = 0;
  for (std::size_t v = 0; v < places.size(); ++v)
    there += length(after.positions[v] - places[v]) < TypeParam(1e-6) ? 1 : 0;
  EXPECT_GT(there, places.size() / 2) << "away from the ball and the pins";
  EXPECT_LT(there, places.size() - 2);
  Scene now = rig.scene;
  now.cloths[0].mesh.positions = rig.inputs();
  EXPECT_NO_THROW(refuse_intersecting_start(now));
}

TEST(Tracking, NeedsOneRankOfTheHost) {
  const Scene fine = hanging_sheet(20);
  const CoarseScene level = make_coarse_scene(fine);
  Scene scene = fine;
  scene.method = "implicit";
  DeviceSet devices = host_devices(2);
  Store<double> store(scene, devices);
  ImplicitStep<double> step(store);
  EXPECT_THROW(step.track(std::make_shared<Tracking>(make_tracking(fine, level))), DeviceError);
}

}  // namespace
}  // namespace weft::test
