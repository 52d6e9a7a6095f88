#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/golden/process.hpp"

/// Tests of every scene that comes with weft.
namespace weft::test {

inline std::vector<std::string> shipped_scenes() {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(fs::path(WEFT_SOURCE_DIR) / "scenes"))
    if (entry.path().extension() == ".json" && entry.path().filename() != "scene.schema.json")
      names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  return names;
}

inline std::string scene_path(const std::string& name) {
  return (fs::path(WEFT_SOURCE_DIR) / "scenes" / (name + ".json")).string();
}

/// How many frames a short run has: `frames`, but one where each is hundreds of steps long.
inline int short_run(const std::string& name, int frames) {
  return name == "cards" ? 1 : frames;
}

/// Overrides that make a scene small; none where its meshes have cells of their own.
inline std::vector<std::string> small(const std::string& name) {
  if (text_of(scene_path(name)).find("\"triangles\"") == std::string::npos) return {};
  return {"--set", "triangles=1000"};
}

/// True if the scene names a file of the package assimp-testmodels and that is not installed.
inline bool lacks_package(const std::string& name) {
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

}  // namespace weft::test
