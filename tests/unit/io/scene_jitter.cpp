#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "host/base/scratch_folder.hpp"
#include "host/io/scene/scene_file.hpp"

namespace weft {
namespace {

class SceneJitter : public testing::Test {
 protected:
  SceneJitter() {
    std::ofstream(file_) << R"({
      "materials": {"cotton": {}},
      "cloths": [{"name": "cloth", "grid": {"size": [1, 1], "cells": [4, 4]},
                  "material": "cotton", "copies": {"count": 2, "translate": [0, 0, 1]}}],
      "pins": [{"cloth": "cloth_0", "box": {"min": [-0.5, -0.5, 0], "max": [0.5, -0.5, 0]}}]
    })";
  }

  Scene read(const std::vector<std::string>& overrides,
             const std::vector<std::string>& experimental = {}) const {
    return io::read_scene(file_, overrides, {}, experimental);
  }

  const ScratchFolder folder_;
  const std::filesystem::path file_ = folder_ / "scene.json";
};

TEST_F(SceneJitter, MovesEveryVertexByItsAmplitudeAtMost) {
  const Scene still = read({});
  const Scene moved = read({"jitter.amplitude=0.01"}, {"jitter.seed=3"});
  double largest = 0;
  std::size_t count = 0;
  for (std::size_t c = 0; c < still.cloths.size(); ++c)
    for (std::size_t v = 0; v < still.cloths[c].mesh.positions.size(); ++v) {
      const Vec3<double> u = moved.cloths[c].mesh.positions[v] - still.cloths[c].mesh.positions[v];
      for (int k = 0; k < 3; ++k) {
        EXPECT_LE(std::abs(u[k]), 0.01 * (1 + 1e-12));
        largest = std::max(largest, std::abs(u[k]));
      }
      count += length(u) > 0 ? 1 : 0;
    }
  EXPECT_EQ(50u, count);
  EXPECT_GT(largest, 0.009);
  for (std::size_t c = 0; c < still.cloths.size(); ++c)
    EXPECT_EQ(still.cloths[c].mesh.material, moved.cloths[c].mesh.material);
  // Vertices are chosen by where they would be.
  EXPECT_EQ(still.pins[0].vertices, moved.pins[0].vertices);
}

TEST_F(SceneJitter, TheSeedDecides) {
  const auto start = [this](const char* seed) {
    return read({"jitter.amplitude=0.01"}, {std::string("jitter.seed=") + seed})
        .cloths[1]
        .mesh.positions;
  };
  EXPECT_EQ(start("1"), start("1"));
  EXPECT_NE(start("1"), start("2"));
  EXPECT_EQ(read({}).cloths[1].mesh.positions,
            read({}, {"jitter.seed=7"}).cloths[1].mesh.positions);
}

TEST_F(SceneJitter, TheResolvedSceneHasIt) {
  const auto resolved = io::read_scene_file(file_, {}, {}, {"jitter.seed=7"}).resolved;
  EXPECT_EQ(7, resolved["experimental"]["jitter.seed"]);
  EXPECT_EQ(0, resolved["jitter"]["amplitude"]);
}

}  // namespace
}  // namespace weft
