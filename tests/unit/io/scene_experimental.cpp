#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "host/base/scratch_folder.hpp"
#include "host/io/scene/scene_file.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

using nlohmann::json;

class SceneExperimental : public testing::Test {
 protected:
  SceneExperimental() { write(scene_); }

  void write(const json& scene) const { std::ofstream(file_) << scene.dump(); }

  SceneFile read(const std::vector<std::string>& experimental,
                 const std::vector<std::string>& overrides = {}) const {
    return read_scene_file(file_, overrides, {}, experimental);
  }

  /// @return why the scene is refused; empty: it is not
  std::string refusal(const std::vector<std::string>& experimental,
                      const std::vector<std::string>& overrides = {}) const {
    try {
      read(experimental, overrides);
    } catch (const SceneError& error) {
      return error.what();
    }
    return {};
  }

  const ScratchFolder folder_;
  const std::filesystem::path file_ = folder_ / "scene.json";
  json scene_{{"materials", {{"cotton", json::object()}}},
              {"cloths",
               {{{"name", "cloth"},
                 {"grid", {{"size", {1, 1}}, {"cells", {4, 4}}}},
                 {"material", "cotton"}}}}};
};

TEST_F(SceneExperimental, SetsTheValueAndRecordsIt) {
  const SceneFile usual = read({});
  EXPECT_EQ(usual.scene.contact.stiffness, 10);
  EXPECT_FALSE(usual.resolved.contains("experimental"));

  const SceneFile set = read({"contact.stiffness=20", "contact.stiffness=30"});
  EXPECT_EQ(set.scene.contact.stiffness, 30) << "the last one counts";
  EXPECT_EQ(set.resolved.at("experimental"), (json{{"contact.stiffness", 30.0}}));
  json without = set.resolved;
  without.erase("experimental");
  EXPECT_EQ(without, usual.resolved);
}

TEST_F(SceneExperimental, AResolvedSceneKeepsIt) {
  const json resolved = read({"contact.stiffness=30"}).resolved;
  write(resolved);
  const SceneFile again = read({});
  EXPECT_EQ(again.scene.contact.stiffness, 30);
  EXPECT_EQ(again.resolved, resolved);
  EXPECT_EQ(read({"contact.stiffness=40"}).scene.contact.stiffness, 40);
}

TEST_F(SceneExperimental, MistakesNameThePathAndWhatIsAllowed) {
  const std::pair<const char*, std::vector<const char*>> mistakes[] = {
      {"contact.stifness=30",
       {": experimental.contact.stifness: unknown key", "allowed: contact.stiffness"}},
      {"contact.friction=0.1",
       {": experimental.contact.friction: unknown key", "allowed: contact.stiffness"}},
      {"contact.stiffness=soft", {": experimental.contact.stiffness: \"soft\"", "a number"}},
      {"contact.stiffness=0",
       {": experimental.contact.stiffness: 0.0;", "a number from 1e-6 to 1e9"}},
      {"contact.stiffness=1e10", {": experimental.contact.stiffness: ", "a number from 1e-6"}},
      {"a\nb=3", {": experimental.a\\nb: unknown key"}},
      {"contact.stiffness", {": --experimental: ", "path=value, such as contact.stiffness=30"}},
      {"=30", {": --experimental: \"=30\"", "path=value, such as contact.stiffness=30"}},
  };
  for (const auto& [text, parts] : mistakes) {
    const std::string message = refusal({text});
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    for (const char* part : parts)
      EXPECT_NE(message.find(part), std::string::npos) << text << ": " << message;
  }
}

TEST_F(SceneExperimental, ScenesOfOtherShapesAreRefused) {
  write(json::array());
  EXPECT_NE(refusal({"contact.stiffness=30"}).find("an object"), std::string::npos);
  scene_["experimental"] = 3;
  write(scene_);
  EXPECT_NE(refusal({"contact.stiffness=30"}).find("experimental: 3;"), std::string::npos);
}

TEST_F(SceneExperimental, IsNoKeyOfContact) {
  const std::string advice =
      ": contact.stiffness: no longer a key: remove it; contacts choose their stiffness themselves";
  EXPECT_EQ(refusal({}, {"contact.stiffness=30"}), file_.string() + advice);
  scene_["contact"]["stiffness"] = 10;
  write(scene_);
  EXPECT_EQ(refusal({}), file_.string() + advice);
  EXPECT_EQ(refusal({"contact.stiffness=30"}), file_.string() + advice);
}

/// Values whose object is among the keys of scenes.
TEST_F(SceneExperimental, SetsWhatIsNoKeyInAnObjectOfKeys) {
  const SceneFile usual = read({});
  EXPECT_FALSE(usual.resolved.at("solver").contains("partial_rows"));
  const std::vector<std::string> values{"solver.partial_rows=64",
                                        "method.time_parallel.recovery.iterations=3"};
  const SceneFile set = read(values);
  EXPECT_EQ(set.scene.solver.partial_rows, 64);
  EXPECT_EQ(set.scene.time_parallel.recovery_iterations, 3);
  EXPECT_EQ(set.resolved.at("experimental"),
            (json{{"solver.partial_rows", 64}, {"method.time_parallel.recovery.iterations", 3}}));
  json without = set.resolved;
  without.erase("experimental");
  EXPECT_EQ(without, usual.resolved);
  write(set.resolved);
  EXPECT_EQ(read({}).resolved, set.resolved);
  EXPECT_EQ(read({}).scene.time_parallel.recovery_iterations, 3);

  write(scene_);
  EXPECT_EQ(refusal({}, {"solver.partial_rows=64"}),
            file_.string() +
                ": solver.partial_rows: 64; allowed: --experimental "
                "solver.partial_rows=VALUE");
  EXPECT_NE(refusal({"solver.partial_rows=65"}).find("solver.partial_rows: 65"), std::string::npos);
  scene_["method"] = 3;
  write(scene_);
  EXPECT_NE(refusal(values).find(": method: 3;"), std::string::npos);
}

/// A misspelt key lists the keys that users may set.
TEST_F(SceneExperimental, IsNoKeyOfScenes) {
  const std::string message = refusal({}, {"experimentl=3"});
  EXPECT_NE(message.find("experimentl: unknown key"), std::string::npos) << message;
  EXPECT_EQ(message.find("experimental"), std::string::npos) << message;
}

}  // namespace
}  // namespace weft::io
