// The runner of jittered starts: what it finds, keeps and repeats; and whole scenes through it.
#include <gtest/gtest.h>

#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/golden/process.hpp"

namespace weft::test {
namespace {

class JitterRuns : public Process {
 protected:
  /// Runs the runner with its results in `results.json`; its output is in out_.
  /// @return its exit code
  int jitter_runs(const std::string& arguments) {
    const std::string command = "cd '" + directory_.string() + "' && '" + WEFT_PYTHON + "' '" +
                                WEFT_SOURCE_DIR + "/benchmarks/support/jitter_runs.py' '" +
                                WEFT_PROGRAM + "' results.json " + arguments + " >out 2>err";
    const int status = std::system(command.c_str());
    out_ = text_of(at("out"));
    err_ = text_of(at("err"));
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  Json results(const std::string& scene) const {
    return Json::parse(text_of(at("results.json"))).at("cases").at(scene);
  }
};

TEST_F(JitterRuns, RunsJudgesAndResumes) {
  const std::string again = "small --scenes . --seeds 1 2 --frames 2 --jobs 2 ";
  ASSERT_EQ(jitter_runs(again + "--commit one"), 0) << out_ << err_;
  const Json first = results("small");
  EXPECT_EQ(first["commit"], "one");
  EXPECT_EQ(first["passed"], 2);
  ASSERT_EQ(first["runs"].size(), 2);
  for (const Json& run : first["runs"]) {
    EXPECT_EQ(run["exit_code"], 0);
    EXPECT_EQ(run["frames"], 2);
    EXPECT_EQ(run["frames_clean"], 3);
    EXPECT_EQ(run["steps_at_fallback_level"]["failed"], 0);
  }
  // Another seed is another start.
  EXPECT_NE(first["runs"][0]["state_hash"], first["runs"][1]["state_hash"]);
  // What is there is kept to the second it was made in, and what is not is added.
  ASSERT_EQ(jitter_runs("small --scenes . --seeds 1 2 3 --frames 2 --commit one"), 0) << err_;
  EXPECT_NE(out_.find("2 runs are there already"), std::string::npos) << out_;
  const Json second = results("small");
  ASSERT_EQ(second["runs"].size(), 3);
  EXPECT_EQ(second["runs"][0], first["runs"][0]);
  EXPECT_EQ(second["runs"][1], first["runs"][1]);
  // Another commit's are repeated; and give the same bits. Entries of other scenes stay.
  write("other.json", small_scene);
  ASSERT_EQ(jitter_runs("other --scenes . --seeds 1 --frames 2 --commit one"), 0) << err_;
  ASSERT_EQ(jitter_runs(again + "--commit two"), 0) << err_;
  EXPECT_EQ(out_.find("already"), std::string::npos) << out_;
  const Json third = results("small");
  ASSERT_EQ(third["runs"].size(), 2);
  EXPECT_EQ(third["runs"][0]["state_hash"], first["runs"][0]["state_hash"]);
  EXPECT_EQ(results("other")["commit"], "one");
}

TEST_F(JitterRuns, WhatTakesTooLongIsStoppedAndRepeatedWithMoreTime) {
  const std::string again = "small --scenes . --seeds 1 --frames 2 --commit one ";
  EXPECT_EQ(jitter_runs(again + "--limit 0.001"), 1) << err_;
  Json run = results("small")["runs"][0];
  EXPECT_EQ(run["timed_out"], true);
  EXPECT_EQ(run["exit_code"], nullptr);
  EXPECT_EQ(run["passes"], false);
  EXPECT_EQ(jitter_runs(again + "--limit 60"), 0) << err_;
  run = results("small")["runs"][0];
  EXPECT_EQ(run["timed_out"], false);
  EXPECT_EQ(run["passes"], true);
}

/// Runs in which cloth displaces boxes end well, but are not clean against the boxes where the
/// scene puts them.
TEST_F(JitterRuns, BodiesHaveToBeWhereTheSceneHasThem) {
  write("press.json", press_scene);
  EXPECT_EQ(jitter_runs("press --scenes . --seeds 1 --commit one"), 1) << out_ << err_;
  const Json run = results("press")["runs"][0];
  EXPECT_EQ(run["exit_code"], 0);
  EXPECT_EQ(run["check_exit_code"], 0);
  EXPECT_GT(run["frames_clean_against_displaced"], 0);
  EXPECT_EQ(run["passes"], false);
  // Until then the boxes are where they should be.
  EXPECT_EQ(jitter_runs("press --scenes . --seeds 1 --frames 4 --commit one"), 0) << out_ << err_;
}

TEST_F(JitterRuns, AnEndThatWasNotExpectedIsWrong) {
  // A scene of this name has to end with a named failure.
  write("plates.json", small_scene);
  EXPECT_EQ(jitter_runs("plates --scenes . --seeds 1 --commit one"), 1) << err_;
  EXPECT_EQ(results("plates")["passed"], 0);
  EXPECT_EQ(jitter_runs("none --scenes ."), 2);
  EXPECT_EQ(line_count(err_), 1) << err_;
  EXPECT_EQ(jitter_runs("small --scenes . --jobs 0"), 2);
  write("results.json", "{");
  EXPECT_EQ(jitter_runs("small --scenes . --commit one"), 2);
}

class SlowJitterRuns : public JitterRuns, public testing::WithParamInterface<const char*> {};

/// One whole scene from a jittered start, another one of the ten every week.
TEST_P(SlowJitterRuns, WholeLength) {
  const std::string scene = GetParam();
  const std::string path = std::string(WEFT_SOURCE_DIR) + "/scenes/" + scene + ".json";
  if (text_of(path).find("/usr/share/assimp/models") != std::string::npos &&
      !fs::exists("/usr/share/assimp/models"))
    GTEST_SKIP() << path << " is NOT TESTED: assimp-testmodels is missing";
  const std::time_t now = std::time(nullptr);
  const int seed = 1 + std::localtime(&now)->tm_yday / 7 % 10;
  EXPECT_EQ(jitter_runs(scene + " --jobs 1 --seeds " + std::to_string(seed)), 0) << out_ << err_;
  EXPECT_EQ(results(scene)["passed"], 1);
}

INSTANTIATE_TEST_SUITE_P(All, SlowJitterRuns,
                         testing::Values("twist", "plates", "tablecloth", "needles", "cards",
                                         "bullet", "mass_ratio", "curtain", "stack", "funnel",
                                         "dancer_skirt", "dress"),
                         [](const auto& scene) { return std::string(scene.param); });

}  // namespace
}  // namespace weft::test
