// Whether energy that nothing gives is noticed, and energy that something gives is left alone.
#include "host/app/run/energy_balance.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <vector>

#include "tests/support/small_scenes.hpp"

namespace weft::app {
namespace {

constexpr double frame = 0.04;

/// Takes frame `number`, of a single step.
void add_frame(EnergyBalance& balance, int number, const Energy& energy) {
  StepReport step;
  step.time = frame * number;
  step.work = 0;
  balance.add(step, energy);
}

/// Frames of a run with so much energy in turn, all of it kinetic, from frame 1 on; each but the
/// first has two steps with half of its work each. [J]
/// @param work [energies - 1] [J] NaN: not known; empty: none
EnergyBalance balance_of(const Scene& scene, const std::vector<double>& energies,
                         const std::vector<double>& work = {}) {
  EnergyBalance balance(scene, {energies.front(), 0, 0});
  for (std::size_t n = 1; n < energies.size(); ++n) {
    StepReport step;
    const double given = work.empty() ? 0 : work[n - 1];
    if (!std::isnan(given)) step.work = given / 2;
    step.time = frame * static_cast<double>(n) - frame / 2;
    balance.add(step, std::nullopt);
    step.time = frame * static_cast<double>(n);
    balance.add(step, Energy{energies[n], 0, 0});
  }
  return balance;
}

Scene still_scene() {
  Scene scene = test::sheet_on_sphere(Precision::double_precision);
  scene.contact.thickness = 1e-5;
  return scene;
}

double gain_of(const std::vector<double>& energies, const std::vector<double>& work = {}) {
  return balance_of(still_scene(), energies, work).gain();
}

TEST(EnergyBalance, FallingEnergyIsInOrder) {
  EXPECT_EQ(gain_of({10, 9, 9.05, 8, 8}), 0);
}

TEST(EnergyBalance, AGainIsNoticedAndMeasuredFromTheLowest) {
  EXPECT_NEAR(gain_of({10, 9, 9.2, 9.3, 9.25}), 0.3, 1e-12);
}

TEST(EnergyBalance, AGainIsFatalInTwoFramesInARow) {
  EXPECT_TRUE(balance_of(still_scene(), {10, 9, 9.2}).suspect());
  EXPECT_FALSE(balance_of(still_scene(), {10, 9, 9.2}).fatal());
  EXPECT_TRUE(balance_of(still_scene(), {10, 9, 9.2, 9.15}).fatal());
  EXPECT_FALSE(balance_of(still_scene(), {10, 9, 9.2, 9.05}).fatal());
  EXPECT_FALSE(balance_of(still_scene(), {10, 9, 9.2, 9.05, 9.2}).fatal());
}

/// Its steps need not dissipate this energy, even where it is stable.
TEST(EnergyBalance, WithBdf2OnlyLargeGainsAreFatal) {
  Scene scene = still_scene();
  scene.integrator = Integrator::bdf2;
  const EnergyBalance small = balance_of(scene, {10, 9, 9.2, 9.2});
  EXPECT_NEAR(small.gain(), 0.2, 1e-12);
  EXPECT_FALSE(small.fatal());
  EXPECT_TRUE(balance_of(scene, {10, 9, 2000, 2000}).fatal());
}

TEST(EnergyBalance, AGainOfAThousandTimesWhatWasAtPlayIsFatalAtOnce) {
  const Scene scene = still_scene();
  for (const double energy : {10000.0, 10100.0}) {
    EnergyBalance balance(scene, {10, 0, 0});
    add_frame(balance, 1, {energy, 0, 0});
    EXPECT_EQ(balance.fatal(), energy > 10050);
    EXPECT_NEAR(balance.gain(), energy - 10, 1e-9);
  }
}

TEST(EnergyBalance, StretchIsFatalIfThereIsMuchAndItLasts) {
  const Scene scene = still_scene();
  for (const double elastic : {900.0, 40000.0}) {
    EnergyBalance balance(scene, {10, 0, 0});
    add_frame(balance, 1, {10, elastic, 0});
    EXPECT_FALSE(balance.fatal());
    EXPECT_NEAR(balance.gain(), elastic, 1e-9);
    add_frame(balance, 2, {9, elastic, 0});
    EXPECT_EQ(balance.fatal(), elastic > 1000);
  }
}

/// Work that is known stretches cloth at once; what impact zones hold back is paid for later.
TEST(EnergyBalance, StretchIsNotFatalBesideWork) {
  const Scene scene = still_scene();
  EnergyBalance balance(scene, {1e-3, 0, 0});
  for (int n = 1; n < 4; ++n) {
    StepReport step;
    step.time = frame * n;
    step.work = n == 1 ? 20 : 0;
    balance.add(step, Energy{0, 29, 0});
    EXPECT_NEAR(balance.gain(), 9, 1e-2);
    EXPECT_FALSE(balance.suspect());
  }
}

/// Cloth that was stretched before may fling itself about with that energy, but with no more.
TEST(EnergyBalance, StretchThatWasThereHidesNothing) {
  const Scene scene = still_scene();
  EnergyBalance balance(scene, {1, 100, 0});
  for (int n = 1; n < 4; ++n) {
    add_frame(balance, n, {n == 1 ? 1.0 : 4.0, 100, 0});
    EXPECT_EQ(balance.fatal(), n == 3);
  }
}

TEST(EnergyBalance, AFallIsNoGain) {
  const Scene scene = still_scene();
  EnergyBalance balance(scene, {0, 0, 10});
  add_frame(balance, 1, {9, 0, 1});
  EXPECT_EQ(balance.gain(), 0);
  add_frame(balance, 2, {9.4, 0, 1});
  EXPECT_NEAR(balance.gain(), 0.4, 1e-12);
}

TEST(EnergyBalance, WorkExplainsAGain) {
  EXPECT_EQ(gain_of({10, 10, 50, 49}, {0, 40, 0}), 0);
  EXPECT_NEAR(gain_of({10, 11, 50, 49}, {0, 39, 0}), 1, 1e-12);
  EXPECT_NEAR(gain_of({10, 10, 50, 52}, {0, 40, 0}), 2, 1e-12);
}

TEST(EnergyBalance, WorkThatIsDoneByClothIsMissedByIt) {
  EXPECT_NEAR(gain_of({10, 10, 9}, {0, -3}), 2, 1e-12);
}

TEST(EnergyBalance, OnePercentIsOfTheWorkToo) {
  EXPECT_EQ(gain_of({10, 10, 10.4}, {30, 0}), 0);
  EXPECT_NEAR(gain_of({10, 10, 10.4}), 0.4, 1e-12);
}

TEST(EnergyBalance, BeginsAgainWhereWorkIsNotKnown) {
  const double unknown = std::nan("");
  EXPECT_EQ(gain_of({10, 20, 50, 50.1}, {0, unknown, 0}), 10);
  EXPECT_EQ(gain_of({10, 10, 50, 50.1}, {0, unknown, 0}), 0);
  EXPECT_NEAR(gain_of({10, 10, 50, 51}, {0, unknown, 0}), 1, 1e-12);
  EXPECT_FALSE(balance_of(still_scene(), {10, 10, 9000, 9000}, {0, unknown, unknown}).fatal());
  EXPECT_FALSE(balance_of(still_scene(), {10, 10, 11000}, {0, unknown}).fatal());
  EXPECT_TRUE(balance_of(still_scene(), {10, 10, 11000, 11000}, {0, unknown, unknown}).fatal());
}

TEST(EnergyBalance, ContactsMayGiveWhatTheyStore) {
  Scene scene = still_scene();
  scene.contact.thickness = 0.01;
  EXPECT_EQ(balance_of(scene, {1e-4, 1.1e-4}).gain(), 0);
  scene.contact.thickness = 1e-8;
  EXPECT_NEAR(balance_of(scene, {1e-4, 1.1e-4}).gain(), 1e-5, 1e-12);
}

}  // namespace
}  // namespace weft::app
