// The scenes that come with weft: they run, and an independent validator finds nothing in their
// frames.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/golden/shipped_scenes.hpp"

namespace weft::test {
namespace {

/// What a run of the whole scene ends with: 4 where that is what the scene shows.
int exit_code(const std::string& name) {
  return name == "plates" ? 4 : 0;
}

TEST_P(ShippedScenes, RunClean) {
  const int frames = short_run(GetParam(), 5);
  std::vector<std::string> arguments{"run",      scene_path(GetParam()), "-o", "a", "--no-preview",
                                     "--frames", std::to_string(frames)};
  const std::vector<std::string> overrides = small(GetParam());
  arguments.insert(arguments.end(), overrides.begin(), overrides.end());
  ASSERT_EQ(weft(arguments), 0) << err_;
  EXPECT_EQ(report("a")["frames"], frames);
  EXPECT_FALSE(report("a").contains("origin")) << "shipped scenes are near (0, 0, 0)";
  EXPECT_EQ(weft({"check", "a"}), 0) << out_ << err_;
}

TEST_P(ShippedScenes, PlanHasALineAStage) {
  std::vector<std::string> arguments{"plan",     scene_path(GetParam()), "--probe", "0", "--json",
                                     "plan.json"};
  const std::vector<std::string> overrides = small(GetParam());
  arguments.insert(arguments.end(), overrides.begin(), overrides.end());
  ASSERT_EQ(weft(arguments), 0) << err_;
  const Json plan = Json::parse(text_of(at("plan.json")));
  for (const Json& s : plan.at("stages")) {
    const std::string stage = s.at("stage").get<std::string>();
    const std::size_t line = out_.find("\n" + stage + " ");
    ASSERT_NE(line, std::string::npos) << stage << ": " << out_;
    const std::string text = out_.substr(line + 1, out_.find('\n', line + 1) - line - 1);
    EXPECT_NE(text.find(s.at("verdict").get<std::string>()), std::string::npos) << text;
    EXPECT_NE(text.find(s.at("why").get<std::string>()), std::string::npos) << text;
    EXPECT_NE(s.at("why"), "") << stage;
  }
  EXPECT_GE(plan.at("stages").size(), 17);
  EXPECT_NE(out_.find(" for the least time: weft run "), std::string::npos) << out_;
}

INSTANTIATE_TEST_SUITE_P(All, ShippedScenes, testing::ValuesIn(shipped_scenes()),
                         [](const auto& scene) { return scene.param; });

class SlowCertifiedScenes : public ShippedScenes {};

/// Proofs that cloth stays apart from itself change no bits.
TEST_P(SlowCertifiedScenes, SameStateWithout) {
  std::vector<std::string> arguments{"run",         scene_path(GetParam()),
                                     "-o",          "with",
                                     "--device",    "cpu:1",
                                     "--frames",    std::to_string(short_run(GetParam(), 25)),
                                     "--no-preview"};
  const std::vector<std::string> overrides = small(GetParam());
  arguments.insert(arguments.end(), overrides.begin(), overrides.end());
  // One that fails in the end has to fail at the same step.
  const int code = weft(arguments);
  arguments[3] = "without";
  arguments.insert(arguments.end(), {"--experimental", "contact.self_certificate=false"});
  ASSERT_EQ(weft(arguments), code) << err_;
  EXPECT_EQ(report("with")["steps"], report("without")["steps"]);
  EXPECT_EQ(hash("with"), hash("without"));
  EXPECT_EQ(report("without")["self_certificate"]["steps"], 0);
  if (GetParam() == "flag") {
    EXPECT_GT(report("with")["self_certificate"]["steps"], 0);
  }
}

INSTANTIATE_TEST_SUITE_P(All, SlowCertifiedScenes, testing::ValuesIn(shipped_scenes()),
                         [](const auto& scene) { return scene.param; });

/// What the adaptive methods refuse a scene for; empty: nothing.
std::string refused_by_adaptive(const std::string& name) {
  if (name == "stitch") return "refine: ";
  if (name == "tablecloth") return "cloths[4].rest: ";
  if (name == "twister") return "obstacles[0].driven: ";
  return {};
}

class SlowAdaptiveScenes : public ShippedScenes {
 protected:
  /// Runs the scene small, by a method that it need not name, and checks every frame.
  void run_clean(const std::string& method) {
    const int frames = short_run(GetParam(), 12);
    std::vector<std::string> arguments{
        "run",      scene_path(GetParam()), "-o",       method, "--no-preview",
        "--frames", std::to_string(frames), "--method", method, "--device",
        "cpu:1"};
    const std::vector<std::string> overrides = small(GetParam());
    arguments.insert(arguments.end(), overrides.begin(), overrides.end());
    const std::string refused = refused_by_adaptive(GetParam());
    ASSERT_EQ(weft(arguments), refused.empty() ? 0 : 2) << err_;
    if (!refused.empty()) {
      EXPECT_NE(err_.find(refused), std::string::npos) << err_;
      return;
    }
    EXPECT_EQ(report(method)["frames"], frames);
    const auto remeshing = report(method)["remeshing"];
    EXPECT_EQ(remeshing["remeshes"], frames);
    if (!remeshing["energy_jump_share"].is_null()) {
      EXPECT_LT(remeshing["energy_jump_share"], 0.01);
    }
    EXPECT_EQ(weft({"check", method}), 0) << out_ << err_;
  }
};

TEST_P(SlowAdaptiveScenes, CleanByAdaptive) {
  run_clean("adaptive");
}

TEST_P(SlowAdaptiveScenes, CleanByView) {
  run_clean("view");
}

INSTANTIATE_TEST_SUITE_P(All, SlowAdaptiveScenes, testing::ValuesIn(shipped_scenes()),
                         [](const auto& scene) { return scene.param; });

class SlowShippedScenes : public ShippedScenes {};

TEST_P(SlowShippedScenes, WholeLength) {
  ASSERT_EQ(weft({"run", scene_path(GetParam()), "-o", "a", "--preview"}), exit_code(GetParam()))
      << err_;
  EXPECT_TRUE(fs::exists(at("a/preview.png")));
  EXPECT_EQ(weft({"check", "a"}), 0) << out_ << err_;
}

INSTANTIATE_TEST_SUITE_P(All, SlowShippedScenes, testing::ValuesIn(shipped_scenes()),
                         [](const auto& scene) { return scene.param; });

class SlowJitteredScenes : public ShippedScenes {};

/// Ten starts that differ by a tenth of a millimetre, small and short enough for ten runs.
TEST_P(SlowJitteredScenes, TenStarts) {
  for (int seed = 1; seed <= 10; ++seed) {
    std::vector<std::string> arguments{"run",
                                       scene_path(GetParam()),
                                       "-o",
                                       "a",
                                       "--no-preview",
                                       "--set",
                                       "jitter.amplitude=1e-4",
                                       "--experimental",
                                       "jitter.seed=" + std::to_string(seed)};
    const std::vector<std::string> overrides = small(GetParam());
    arguments.insert(arguments.end(), overrides.begin(), overrides.end());
    // One that fails in the end has to get there.
    if (exit_code(GetParam()) == 0) {
      arguments.emplace_back("--frames");
      arguments.push_back(std::to_string(short_run(GetParam(), 12)));
    }
    ASSERT_EQ(weft(arguments), exit_code(GetParam())) << "seed " << seed << ": " << err_;
    EXPECT_EQ(weft({"check", "a"}), 0) << "seed " << seed << ": " << out_ << err_;
    fs::remove_all(at("a"));
  }
}

INSTANTIATE_TEST_SUITE_P(All, SlowJitteredScenes, testing::ValuesIn(shipped_scenes()),
                         [](const auto& scene) { return scene.param; });

/// Two plates close on a sheet: the run ends, soon, with what happened, its last good state and all
/// counts.
TEST_F(Process, PlatesEndWithANamedFailure) {
  ASSERT_EQ(
      weft({"run", scene_path("plates"), "-o", "a", "--no-preview", "--set", "triangles=500"}), 4)
      << out_ << err_;
  EXPECT_EQ(line_count(err_), 1) << err_;
  for (const char* part : {"pinched: cloth keeps ", "upper", " m short at (",
                           "contact.compliance_distance allows 0; checkpoint a/checkpoint_"})
    EXPECT_NE(err_.find(part), std::string::npos) << part << " in " << err_;
  const Json r = report("a");
  const Json& contacts = r["contacts"];
  EXPECT_EQ(contacts["steps_at_fallback_level"]["failed"], 1);
  EXPECT_GT(contacts["steps_at_fallback_level"]["whole"], 100);
  EXPECT_GT(contacts["zones_unsolved_total"], 0);
  EXPECT_GT(contacts["zone_largest"], 0);
  EXPECT_GT(contacts["zone_passes_total"], 0);
  EXPECT_GT(contacts["zone_rounds_max"], 0);
  EXPECT_EQ(contacts["compliance_distance_max"], 0);
  EXPECT_EQ(r["intersections"], 0);
  EXPECT_EQ(weft({"check", "a"}), 0) << out_ << err_;
  // The checkpoint is whole; the plates close all the same.
  EXPECT_EQ(weft({"run", scene_path("plates"), "-o", "a", "--no-preview", "--set", "triangles=500",
                  "--resume", "latest"}),
            4)
      << out_ << err_;
}

}  // namespace
}  // namespace weft::test
