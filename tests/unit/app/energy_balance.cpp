// Whether energy that nothing gives is noticed, and energy that something gives is left alone.
#include "host/app/run/energy_balance.hpp"

#include <gtest/gtest.h>

#include <optional>
#include <utility>
#include <vector>

#include "tests/support/small_scenes.hpp"

namespace weft::app {
namespace {

constexpr double frame = 0.04;

/// Takes frame `number`, of a single step.
void add_frame(EnergyBalance& balance, int number, const Energy& energy) {
  StepReport step;
  step.time = frame * number;
  balance.add(step, energy);
}

/// Frames of a run with so much energy in turn, all of it kinetic, from frame 1 on. [J]
double gain_of(const Scene& scene, const std::vector<double>& energies,
               const StepReport& report = {}) {
  EnergyBalance balance(scene, {energies.front(), 0, 0});
  for (std::size_t n = 1; n < energies.size(); ++n) {
    StepReport step = report;
    step.time = frame * static_cast<double>(n) - frame / 2;
    balance.add(step, std::nullopt);
    step.time = frame * static_cast<double>(n);
    balance.add(step, Energy{energies[n], 0, 0});
  }
  return balance.gain();
}

Scene still_scene() {
  Scene scene = test::sheet_on_sphere(Precision::double_precision);
  scene.contact.thickness = 1e-5;
  return scene;
}

/// The same with a sphere that moves in the second frame.
Scene moving_scene() {
  Scene scene = still_scene();
  Keyframe from, to;
  from.time = 1.2 * frame;
  to.time = 1.8 * frame;
  to.transform.translate = {0, 0, 1};
  scene.obstacles[0].motion = {from, to};
  return scene;
}

TEST(EnergyBalance, FallingEnergyIsInOrder) {
  EXPECT_EQ(gain_of(still_scene(), {10, 9, 9.05, 8, 8}), 0);
}

TEST(EnergyBalance, AGainIsNoticedAndMeasuredFromTheLowest) {
  EXPECT_NEAR(gain_of(still_scene(), {10, 9, 9.2, 9.3, 9.25}), 0.3, 1e-12);
}

TEST(EnergyBalance, AGainOfAThousandTimesWhatWasAtPlayIsAnExplosion) {
  const Scene scene = still_scene();
  for (const double energy : {10000.0, 10100.0}) {
    EnergyBalance balance(scene, {10, 0, 0});
    add_frame(balance, 1, {energy, 0, 0});
    EXPECT_EQ(balance.exploded(), energy > 10050);
    EXPECT_NEAR(balance.gain(), energy - 10, 1e-9);
    add_frame(balance, 2, {energy, 0, 0});
    EXPECT_FALSE(balance.exploded());
  }
}

TEST(EnergyBalance, StretchAloneIsNoExplosion) {
  const Scene scene = still_scene();
  EnergyBalance balance(scene, {10, 0, 0});
  add_frame(balance, 1, {10, 40000, 0});
  EXPECT_FALSE(balance.exploded());
  EXPECT_NEAR(balance.gain(), 40000, 1e-9);
}

TEST(EnergyBalance, AFallIsNoGain) {
  const Scene scene = still_scene();
  EnergyBalance balance(scene, {0, 0, 10});
  add_frame(balance, 1, {9, 0, 1});
  EXPECT_EQ(balance.gain(), 0);
  add_frame(balance, 2, {9.4, 0, 1});
  EXPECT_NEAR(balance.gain(), 0.4, 1e-12);
}

TEST(EnergyBalance, ABodyMayGiveEnergyWhileItMovesOnly) {
  EXPECT_EQ(gain_of(moving_scene(), {10, 10, 50, 49}), 0);
  EXPECT_NEAR(gain_of(moving_scene(), {10, 11, 50, 49}), 1, 1e-12);
  EXPECT_NEAR(gain_of(moving_scene(), {10, 10, 50, 52}), 2, 1e-12);
}

TEST(EnergyBalance, SoMayPins) {
  Scene scene = moving_scene();
  Pin pin;
  pin.motion = std::exchange(scene.obstacles[0].motion, {});
  scene.pins = {pin};
  EXPECT_EQ(gain_of(scene, {10, 10, 50, 49}), 0);
  EXPECT_NEAR(gain_of(scene, {10, 10, 50, 52}), 2, 1e-12);
}

TEST(EnergyBalance, OpenSeamsAndBodiesThatGiveWayMayGiveEnergy) {
  StepReport report;
  report.open_seam_pairs = 1;
  EXPECT_EQ(gain_of(still_scene(), {10, 20}, report), 0);
  report = {};
  report.compliance_distance = 1e-3;
  EXPECT_EQ(gain_of(still_scene(), {10, 20}, report), 0);
  report = {};
  report.remesh.splits = 1;
  EXPECT_EQ(gain_of(still_scene(), {10, 20}, report), 0);
}

TEST(EnergyBalance, SoMayWindAndPressure) {
  Scene windy = still_scene();
  windy.wind.density = 1.2;
  EXPECT_EQ(gain_of(windy, {10, 20}), 0);
  Scene inflated = still_scene();
  inflated.cloths[0].pressure = 10;
  EXPECT_EQ(gain_of(inflated, {10, 20}), 0);
}

TEST(EnergyBalance, ContactsMayGiveWhatTheyStore) {
  Scene scene = still_scene();
  scene.contact.thickness = 0.01;
  EXPECT_EQ(gain_of(scene, {1e-4, 1.1e-4}), 0);
  scene.contact.thickness = 1e-8;
  EXPECT_NEAR(gain_of(scene, {1e-4, 1.1e-4}), 1e-5, 1e-12);
}

}  // namespace
}  // namespace weft::app
