// The scenes that come with weft: they run, and an independent judge finds nothing in their frames.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/golden/process.hpp"

namespace weft::test {
namespace {

std::vector<std::string> shipped_scenes() {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(fs::path(WEFT_SOURCE_DIR) / "scenes"))
    if (entry.path().extension() == ".json" && entry.path().filename() != "scene.schema.json")
      names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  return names;
}

std::string scene_path(const std::string& name) {
  return (fs::path(WEFT_SOURCE_DIR) / "scenes" / (name + ".json")).string();
}

/// True if the scene names a file of the package assimp-testmodels and that is not installed.
bool lacks_package(const std::string& name) {
  const fs::path models = "/usr/share/assimp/models";
  return text_of(scene_path(name)).find(models.string()) != std::string::npos &&
         !fs::exists(models);
}

class ShippedScenes : public Process, public testing::WithParamInterface<std::string> {
 protected:
  void SetUp() override {
    Process::SetUp();
    if (lacks_package(GetParam()))
      GTEST_SKIP() << "scenes/" << GetParam()
                   << ".json is NOT TESTED: assimp-testmodels is missing";
  }
};

TEST_P(ShippedScenes, RunClean) {
  ASSERT_EQ(weft({"run", scene_path(GetParam()), "-o", "a", "--no-preview", "--frames", "5",
                  "--set", "triangles=1000"}),
            0)
      << err_;
  EXPECT_EQ(report("a")["frames"], 5);
  EXPECT_EQ(weft({"check", "a"}), 0) << out_ << err_;
}

INSTANTIATE_TEST_SUITE_P(All, ShippedScenes, testing::ValuesIn(shipped_scenes()),
                         [](const auto& scene) { return scene.param; });

class SlowShippedScenes : public ShippedScenes {};

TEST_P(SlowShippedScenes, WholeLength) {
  ASSERT_EQ(weft({"run", scene_path(GetParam()), "-o", "a"}), 0) << err_;
  EXPECT_TRUE(fs::exists(at("a/preview.png")));
  EXPECT_EQ(weft({"check", "a"}), 0) << out_ << err_;
}

INSTANTIATE_TEST_SUITE_P(All, SlowShippedScenes, testing::ValuesIn(shipped_scenes()),
                         [](const auto& scene) { return scene.param; });

}  // namespace
}  // namespace weft::test
