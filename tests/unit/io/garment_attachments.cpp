// Attached edges of garments become level, at the place where they are held.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <vector>

#include "host/io/scene/scene_file.hpp"
#include "host/model/model.hpp"
#include "host/model/springs.hpp"
#include "tests/unit/io/directories.hpp"
#include "weft/core/at.hpp"
#include "weft/simulation.hpp"

namespace weft::io {
namespace {

using nlohmann::json;

constexpr double time_to_place = 1;  ///< [s] after which a held edge has to be level
constexpr double body_height = 1.3;  ///< [m] of the middle of a body behind the panel

class GarmentAttachments : public DirectoryTest {
 protected:
  /// A panel of 40 by 30 cm whose upper edge, "waist", rises by 10 cm from left to right.
  Scene read(const json& attachment, const json& obstacles = json::array()) const {
    const json panel = {{"vertices", {{0, 0}, {40, 0}, {40, 40}, {0, 30}}},
                        {"edges",
                         {{{"endpoints", {0, 1}}},
                          {{"endpoints", {1, 2}}},
                          {{"endpoints", {2, 3}}, {"label", "waist"}},
                          {{"endpoints", {3, 0}}}}},
                        {"translation", {0, 100, 0}}};
    const json pattern = {
        {"pattern", {{"panels", {{"panel", panel}}}, {"stitches", json::array()}}},
        {"properties", {{"units_in_meter", 100}}}};
    put("pattern.json", pattern.dump());
    const json garment = {
        {"name", "sheet"}, {"pattern", "pattern.json"}, {"edge", 0.05}, {"attach", {attachment}}};
    const json scene = {{"time", {{"step", 0.005}, {"frame_rate", 25}, {"frames", 50}}},
                        {"garments", {garment}},
                        {"obstacles", obstacles}};
    return read_scene(put("scene.json", scene.dump()));
  }
};

/// [m] Heights of the vertices that a scene's only handle holds.
template <class Positions>
std::vector<double> held_heights(const Scene& scene, const Positions& positions) {
  std::vector<double> heights;
  for (const Index v : scene.handles.at(0).vertices) heights.push_back(positions[at(v)][2]);
  return heights;
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

double spread(const std::vector<double>& values) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return *high - *low;
}

TEST_F(GarmentAttachments, SpringsStartWhereVerticesAreAndEndAtOneHeight) {
  const Scene scene = read({{"label", "waist"}});
  ASSERT_EQ(scene.handles.size(), 1u);
  const auto heights = held_heights(scene, scene.cloths[0].mesh.positions);
  ASSERT_GT(spread(heights), 0.09);
  const Model model = make_model(scene);
  const auto targets = [&](double time) {
    std::vector<double> anchors;
    for (const Spring<double>& spring : springs_at(scene, model, time)) {
      EXPECT_EQ(spring.along, (Vec3<double>{0, 0, 1}));
      anchors.push_back(spring.anchor[2]);
    }
    return anchors;
  };
  const auto begin = targets(0), end = targets(time_to_place);
  ASSERT_EQ(begin.size(), heights.size());
  ASSERT_EQ(end.size(), heights.size());
  for (std::size_t k = 0; k < heights.size(); ++k) {
    EXPECT_NEAR(begin[k], heights[k], 1e-12) << k;
    EXPECT_NEAR(end[k], mean(heights), 1e-6) << k;
  }
}

TEST_F(GarmentAttachments, EdgeBecomesLevel) {
  for (const bool placed : {false, true}) {
    json attachment{{"label", "waist"}};
    if (placed) attachment["at"] = 1.2;
    const Scene scene = read(attachment);
    const double place = placed ? 1.2 : mean(held_heights(scene, scene.cloths[0].mesh.positions));
    Simulation simulation(scene, host_devices(1));
    const int steps = static_cast<int>(std::lround(1.2 * time_to_place / 0.005));
    for (int step = 0; step < steps; ++step)
      ASSERT_EQ(simulation.step().failure, Failure::none) << step;
    const auto heights = held_heights(scene, simulation.positions({0, scene.identity.number()}));
    // Its weight stretches the springs by micrometres.
    EXPECT_LT(spread(heights), 0.005) << placed;
    EXPECT_NEAR(mean(heights), place, 0.002) << placed;
  }
}

/// A body behind the panel, and how it moves from 1 s to 2 s: up, and bent backwards if it turns.
json moving_body(double rise, double angle) {
  const json start = {0.2, 0.2, body_height};
  return {{"name", "body"},
          {"box", {{"size", {0.4, 0.2, 0.2}}}},
          {"motion",
           {{{"time", 1}, {"translate", start}},
            {{"time", 2},
             {"translate", {0.2, 0.2, body_height + rise}},
             {"rotate", {angle, 1, 0, 0}}}}}};
}

TEST_F(GarmentAttachments, SpringsFollowTheBodyBeneath) {
  const json body = moving_body(0.1, 90);
  const json far = {{"name", "far"},
                    {"box", {{"size", {0.1, 0.1, 0.1}}}},
                    {"transform", {{"translate", {0, 2, 1}}}}};
  Scene scene = read({{"label", "waist"}}, {far, body});
  const double height = mean(held_heights(scene, scene.cloths[0].mesh.positions));
  Model model = make_model(scene);
  for (const Spring<double>& spring : springs_at(scene, model, 1)) {
    EXPECT_NEAR(spring.anchor[2], height, 1e-6);
    EXPECT_NEAR(length(spring.along - Vec3<double>{0, 0, 1}), 0, 1e-12);
  }
  // A quarter turn takes (x, y, z) to (x, -z, y).
  for (const Spring<double>& spring : springs_at(scene, model, 2)) {
    EXPECT_NEAR(spring.anchor[1], 0.2 - (height - body_height), 1e-6);
    EXPECT_NEAR(length(spring.along - Vec3<double>{0, -1, 0}), 0, 1e-12);
  }
  scene = read({{"label", "waist"}, {"along", nullptr}}, {far, body});
  model = make_model(scene);
  const auto springs = springs_at(scene, model, 2);
  for (std::size_t k = 0; k < springs.size(); ++k) {
    const Vec3<double> x = scene.cloths[0].mesh.positions[at(scene.handles[0].vertices[k])];
    const Vec3<double> expected{x[0], 0.2 - (x[2] - body_height), body_height + 0.1 + x[1] - 0.2};
    EXPECT_NEAR(length(springs[k].anchor - expected), 0, 1e-9) << k;
    EXPECT_EQ(springs[k].along, (Vec3<double>{0, 0, 0}));
  }
}

TEST_F(GarmentAttachments, SpringsHoldInTheWorldWhereTheNearestObstacleStandsStill) {
  json still = moving_body(0, 0), far = moving_body(0.1, 0);
  still.erase("motion");
  still["transform"] = {{"translate", {0.2, 0.2, body_height}}};
  far["name"] = "far";
  for (json& key : far["motion"]) key["translate"][1] = 0.6;
  const Scene held = read({{"label", "waist"}}), beside = read({{"label", "waist"}}, {still, far});
  EXPECT_EQ(beside.handles.at(0).carrier.obstacle, -1);
  EXPECT_EQ(held.handles.at(0).carrier.obstacle, -1);
}

TEST_F(GarmentAttachments, EdgeFollowsTheBody) {
  for (const double angle : {0.0, 40.0}) {
    Scene scene = read({{"label", "waist"}}, json::array({moving_body(0.3, angle)}));
    scene.time.frames = 100;
    const double height = mean(held_heights(scene, scene.cloths[0].mesh.positions));
    std::optional<std::uint64_t> hash;
    for (const int devices : {1, 2}) {
      Simulation simulation(scene, host_devices(devices));
      const auto total = [&] {
        const Energy e = simulation.energy();
        return e.kinetic + e.elastic + e.gravitational;
      };
      const double before = total();
      double work = 0;
      while (simulation.time() < 2.5) {
        const StepReport report = simulation.step();
        ASSERT_EQ(report.failure, Failure::none) << simulation.time();
        work += report.work.value_or(0);
      }
      EXPECT_LT(total() - before, work);
      EXPECT_NEAR(total() - before, work, 0.005);
      const auto positions = simulation.positions({0, scene.identity.number()});
      for (const Index v : scene.handles[0].vertices) {
        const double turn = angle * std::numbers::pi / 180;
        const Vec3<double> along{0, -std::sin(turn), std::cos(turn)};
        const Vec3<double> x =
            vec_cast<double>(positions[at(v)]) - Vec3<double>{0.2, 0.2, body_height + 0.3};
        EXPECT_NEAR(dot(x, along), height - body_height, 0.005) << v;
      }
      EXPECT_EQ(simulation.state_hash(), hash.value_or(simulation.state_hash()));
      hash = simulation.state_hash();
    }
  }
}

/// A held panel that swings in long steps turns far in each of them.
TEST_F(GarmentAttachments, SwingsWithoutNewtonsMethodUntilItRests) {
  for (const RunUntil until : {RunUntil::frames, RunUntil::rest}) {
    Scene scene = read({{"label", "waist"}, {"along", nullptr}});
    scene.time.step = 0.04;
    scene.time.until = until;
    scene.gravity = {0, 30, -9.81};
    Simulation simulation(scene, host_devices(1));
    int more = 0;
    for (int step = 0; step < 25; ++step) {
      const StepReport report = simulation.step();
      ASSERT_EQ(report.failure, Failure::none) << step;
      ASSERT_EQ(report.retries, 0) << step;
      more += report.newton_iterations - 1;
    }
    EXPECT_EQ(more > 0, until == RunUntil::frames) << more;
  }
}

}  // namespace
}  // namespace weft::io
