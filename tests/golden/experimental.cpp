// `--experimental`: values that are no keys of scenes.
#include <string>
#include <vector>

#include "tests/golden/process.hpp"

namespace weft::test {
namespace {

class ExperimentalOption : public Process {
 protected:
  static constexpr double stiffness = 300;
  const std::vector<std::string> set_{"--experimental", "contact.stiffness=300"};

  static std::vector<std::string> joined(std::vector<std::string> words,
                                         const std::vector<std::string>& more) {
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }

  /// Of the scene.json of a run; null: none.
  Json values_of(const std::string& output) const {
    return Json::parse(text_of(at(output) / "scene.json")).value("experimental", Json());
  }

  /// Whether all runs somewhere below a folder have the value of `set_`.
  void expect_in_all_runs(const std::string& folder) const {
    int runs = 0;
    for (const auto& entry : fs::recursive_directory_iterator(at(folder))) {
      if (entry.path().filename() != "scene.json") continue;
      ++runs;
      const Json scene = Json::parse(text_of(entry.path()));
      ASSERT_TRUE(scene.contains("experimental")) << entry.path();
      EXPECT_EQ(scene.at("experimental").at("contact.stiffness"), stiffness) << entry.path();
    }
    EXPECT_GT(runs, 0);
  }
};

TEST_F(ExperimentalOption, ChangesTheRunAndIsRecorded) {
  ASSERT_EQ(run("usual"), 0) << err_;
  ASSERT_EQ(run("same", {"--experimental", "contact.stiffness=10"}), 0) << err_;
  ASSERT_EQ(run("stiff", set_), 0) << err_;
  EXPECT_EQ(hash("same"), hash("usual"));
  EXPECT_NE(hash("stiff"), hash("usual"));
  EXPECT_EQ(values_of("usual"), nullptr);
  EXPECT_EQ(values_of("stiff"), (Json{{"contact.stiffness", stiffness}}));
  // What a run has written can be run again.
  ASSERT_EQ(weft({"run", "stiff/scene.json", "-o", "again", "--no-preview"}), 0) << err_;
  EXPECT_EQ(hash("again"), hash("stiff"));
  EXPECT_EQ(weft({"check", "stiff"}), 0) << err_;
}

TEST_F(ExperimentalOption, MistakesAreOneLine) {
  for (const std::string subcommand : {"run", "plan", "chart"})
    for (const std::string text : {"contact.stifness=3", "contact.stiffness=soft", "nonsense"}) {
      EXPECT_EQ(weft({subcommand, "small.json", "--experimental", text}), 2) << err_;
      EXPECT_EQ(line_count(err_), 1) << err_;
      EXPECT_NE(err_.find("experimental"), std::string::npos) << err_;
      EXPECT_EQ(out_, "");
    }
}

TEST_F(ExperimentalOption, AResumedRunKeepsIt) {
  ASSERT_EQ(run("whole", set_), 0) << err_;
  ASSERT_EQ(run("part", joined({"--frames", "2"}, set_)), 0) << err_;
  // Its own scene knows the value.
  ASSERT_EQ(weft({"run", "part/scene.json", "-o", "part", "--no-preview", "--resume", "latest",
                  "--frames", "6"}),
            0)
      << err_;
  EXPECT_EQ(hash("part"), hash("whole"));
  EXPECT_EQ(values_of("part"), (Json{{"contact.stiffness", stiffness}}));
}

TEST_F(ExperimentalOption, AResumedRunThatDiffersIsRefused) {
  ASSERT_EQ(run("part", joined({"--frames", "2"}, set_)), 0) << err_;
  EXPECT_EQ(run("part", {"--resume", "latest"}), 2) << out_;
  EXPECT_EQ(line_count(err_), 1) << err_;
  EXPECT_NE(err_.find("contact.stiffness was 300, now 10"), std::string::npos) << err_;
  EXPECT_EQ(run("part", joined({"--resume", "latest"}, set_)), 0) << err_;
}

TEST_F(ExperimentalOption, SlicesOfTimeKeepIt) {
  const std::vector<std::string> slices{"--method", "time_parallel", "--set",
                                        "method.time_parallel.slices=2"};
  ASSERT_EQ(run("usual", slices), 0) << err_;
  ASSERT_EQ(run("threads", joined(slices, set_)), 0) << err_;
  ASSERT_EQ(run("processes", joined(joined(slices, set_), {"--processes"})), 0) << err_;
  EXPECT_NE(hash("threads"), hash("usual"));
  EXPECT_EQ(hash("processes"), hash("threads"));
  EXPECT_EQ(run("threads", joined(slices, {"--resume", "latest"})), 2) << out_;
  EXPECT_EQ(line_count(err_), 1) << err_;
  EXPECT_NE(err_.find("other values of experimental"), std::string::npos) << err_;
}

/// Programs that run others.
class ExperimentalRuns : public ExperimentalOption {
 protected:
  void SetUp() override {
    Json scene = Json::parse(small_scene);
    scene["cloths"] = Json::array({scene["cloths"][0]});
    scene["cloths"][0]["grid"].erase("cells");
    scene["triangles"] = 200;
    scene["time"] = {{"step", 0.01}, {"frame_rate", 25}, {"frames", 2}};
    write("small.json", scene.dump());
  }
};

TEST_F(ExperimentalRuns, AnAccuracyTargetPassesItOn) {
  ASSERT_EQ(run("a", joined({"--need", "error<90%"}, set_)), 0) << err_;
  expect_in_all_runs("a");
}

TEST_F(ExperimentalRuns, AChartPassesItOn) {
  ASSERT_NE(weft(joined({"chart", "small.json", "-o", "charts", "--quick", "--runs", "1",
                         "--reference-steps", "2"},
                        set_)),
            4)
      << err_;
  expect_in_all_runs("charts");
  const Json chart = Json::parse(text_of(at("charts/small/chart.json")));
  for (const Json& point : chart.at("points"))
    EXPECT_NE(point.at("command").get<std::string>().find("--experimental contact.stiffness=300"),
              std::string::npos)
        << point;
}

TEST_F(ExperimentalRuns, APlanPassesItOn) {
  const std::vector<std::string> plan{"plan",    "small.json", "--probe", "0",
                                      "--steps", "--json",     "p.json"};
  ASSERT_EQ(weft(plan), 0) << err_;
  const Json usual = Json::parse(text_of(at("p.json"))).at("time_steps");
  EXPECT_EQ(out_.find("--experimental"), std::string::npos) << out_;
  ASSERT_EQ(weft(joined(plan, set_)), 0) << err_;
  EXPECT_NE(out_.find(" --experimental contact.stiffness=300"), std::string::npos) << out_;
  const Json stiff = Json::parse(text_of(at("p.json"))).at("time_steps");
  EXPECT_NE(stiff.at("trials").at(0).at("error"), usual.at("trials").at(0).at("error"))
      << "its runs have the value too";
}

}  // namespace
}  // namespace weft::test
