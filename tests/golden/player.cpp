// `weft view`, run as a program: which runs it reads, what the page holds, which arguments are
// refused. tests/browser/player_page.py looks at the page itself.
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tests/golden/process.hpp"

namespace weft::test {
namespace {

class ViewSubcommand : public Process {
 protected:
  void SetUp() override {
    Process::SetUp();
    ASSERT_EQ(run("run", {"--frames", "3"}), 0) << err_;
    if (weft({"view", "run", "-o", "probe.html"}) == 2 &&
        err_.find("lacks three.js") != std::string::npos) {
      EXPECT_EQ(line_count(err_), 1) << err_;
      GTEST_SKIP() << "this build lacks three.js";
    }
  }

  /// What a page holds.
  Json data(const std::string& page) const {
    const std::string text = text_of(at(page));
    const std::string before = "<script type=\"application/json\" id=\"data\">";
    const std::size_t start = text.find(before) + before.size();
    return Json::parse(text.substr(start, text.find("</script>", start) - start));
  }

  void expect_refused(const std::vector<std::string>& arguments, const std::string& word) {
    std::vector<std::string> all{"view"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    EXPECT_EQ(weft(all), 2) << word;
    EXPECT_EQ(line_count(err_), 1) << err_;
    EXPECT_NE(err_.find(word), std::string::npos) << err_;
    EXPECT_EQ(err_.find("internal error"), std::string::npos) << err_;
  }
};

TEST_F(ViewSubcommand, MakesOnePageThatSaysWhatItIs) {
  ASSERT_EQ(weft({"view", "run"}), 0) << err_;
  EXPECT_EQ(err_, "");
  EXPECT_NE(out_.find("4 frames in run/view.html"), std::string::npos) << out_;
  const std::string page = text_of(at("run/view.html"));
  EXPECT_TRUE(page.starts_with("<!doctype html>"));
  EXPECT_NE(page.find("Permission is hereby granted, free of charge"), std::string::npos);
  EXPECT_NE(page.find("content=\"default-src 'none'; script-src 'sha256-"), std::string::npos);
  EXPECT_EQ(page.find("<script src"), std::string::npos) << "nothing is fetched";
  EXPECT_EQ(page.find("@DATA@"), std::string::npos);
  EXPECT_EQ(text_of(at("run/view.html")), text_of(at("probe.html")));
}

TEST_F(ViewSubcommand, HoldsFramesNamesScalesAndSteps) {
  const Json run = data("probe.html").at("runs").at(0);
  ASSERT_EQ(run.at("frames").size(), 4u);
  EXPECT_EQ(run.at("frames")[3].at("number"), 3);
  EXPECT_DOUBLE_EQ(run.at("frames")[3].at("time"), 3.0 / 25);
  const Json topology = run.at("topologies").at(0);
  EXPECT_EQ(topology.at("cloths")[1].at("name"), "upper");
  EXPECT_EQ(topology.at("cloths")[1].at("triangles"), 72);
  EXPECT_EQ(topology.at("obstacles")[0].at("name"), "ball");
  EXPECT_GT(run.at("scales").at("strain"), 0);
  EXPECT_EQ(run.at("scales").at("contact"), 2);
  EXPECT_EQ(run.at("scales").at("compliance"), 0);
  EXPECT_EQ(run.at("facts").at("method"), "implicit");
  ASSERT_EQ(run.at("facts").at("steps").size(), 24u);
  EXPECT_EQ(run.at("facts").at("steps")[23].size(), run.at("facts").at("step_fields").size());
}

TEST_F(ViewSubcommand, ReadsEveryFormatOfFrames) {
  for (const std::string format : {"ply", "pc2", "usda"}) {
    ASSERT_EQ(run(format, {"--frames", "3", "--set", "output.format=" + format}), 0) << err_;
    ASSERT_EQ(weft({"view", format}), 0) << err_;
    const Json run = data(format + "/view.html").at("runs").at(0);
    EXPECT_EQ(run.at("frames").size(), 4u) << format;
    EXPECT_EQ(run.at("topologies").at(0).at("cloths").size(), 2u) << format;
    EXPECT_EQ(run.at("topologies").at(0).at("obstacles").size(), 1u) << format;
  }
}

TEST_F(ViewSubcommand, FramesMayBeChosenAndRunsStandBesideEachOther) {
  ASSERT_EQ(run("other", {"--frames", "2"}), 0) << err_;
  ASSERT_EQ(weft({"view", "run", "--beside", "other", "--frames", "::2", "-o", "both.html"}), 0)
      << err_;
  const Json runs = data("both.html").at("runs");
  ASSERT_EQ(runs.size(), 2u);
  EXPECT_EQ(runs[0].at("frames").size(), 2u);
  EXPECT_EQ(runs[0].at("scales").at("strain"), runs[1].at("scales").at("strain"));
}

TEST_F(ViewSubcommand, ShowsWhereClothDisplacedObstacles) {
  write("press.json", press_scene);
  ASSERT_EQ(weft({"run", "press.json", "-o", "press", "--no-preview"}), 0) << err_;
  ASSERT_EQ(weft({"view", "press"}), 0) << err_;
  const Json run = data("press/view.html").at("runs").at(0);
  EXPECT_GT(run.at("scales").at("compliance"), 1e-5);
  EXPECT_EQ(run.at("frames").front().at("compliance"), -1);
  EXPECT_GE(run.at("frames").back().at("compliance"), 0);
  fs::copy_file(at("run/frames/obstacle.obj"), at("press/displaced/displaced_00007.obj"),
                fs::copy_options::overwrite_existing);
  expect_refused({"press"}, "displaced_00007.obj");
}

TEST_F(ViewSubcommand, ShowsWherePinsAreBesideTheirPlaces) {
  std::string scene = small_scene;
  const std::string before = "\"obstacles\"";
  scene.insert(scene.find(before), "\"pins\": [{\"cloth\": \"lower\", \"vertices\": [0]}], ");
  write("small.json", scene);
  ASSERT_EQ(run("pinned", {"--frames", "2"}), 0) << err_;
  ASSERT_EQ(weft({"view", "pinned"}), 0) << err_;
  const Json held = data("pinned/view.html").at("runs").at(0);
  EXPECT_EQ(held.at("scales").at("compliance"), 0);
  EXPECT_EQ(held.at("frames").back().at("pins"), -1);
  // Frame 1 as if cloth had displaced the pin by 3 mm.
  const std::string file = "pinned/frames/cloth_00001.obj";
  std::string text = text_of(at(file));
  const std::size_t start = text.find("\nv ") + 1, end = text.find('\n', start);
  double x = 0, y = 0, z = 0;
  ASSERT_EQ(std::sscanf(text.c_str() + start, "v %lf %lf %lf", &x, &y, &z), 3);
  const std::string moved =
      "v " + std::to_string(x) + " " + std::to_string(y) + " " + std::to_string(z + 0.003);
  write(file, text.replace(start, end - start, moved));
  ASSERT_EQ(weft({"view", "pinned"}), 0) << err_;
  const Json displaced = data("pinned/view.html").at("runs").at(0);
  EXPECT_NEAR(displaced.at("scales").at("compliance").get<double>(), 0.003, 1.1e-4);
  EXPECT_GE(displaced.at("frames")[1].at("pins"), 0);
}

TEST_F(ViewSubcommand, AnAnimationWithoutARunHasNoFacts) {
  ASSERT_EQ(weft({"convert", "run", "some.usda"}), 0) << err_;
  ASSERT_EQ(weft({"view", "some.usda"}), 0) << err_;
  const Json run = data("view.html").at("runs").at(0);
  EXPECT_EQ(run.at("frames").size(), 4u);
  EXPECT_EQ(run.at("facts").at("steps").size(), 0u);
  EXPECT_EQ(run.at("scales").at("contact"), 0) << "the thickness is not known";
}

TEST_F(ViewSubcommand, NamesOfAStrangerStayData) {
  // weft allows no such names in scenes.
  const std::string name = "</script><script>alert(1)</script>";
  fs::remove(at("run/scene.json"));
  for (int k = 0; k < 4; ++k) {
    const std::string file = "run/frames/cloth_0000" + std::to_string(k) + ".obj";
    std::string text = text_of(at(file));
    const std::size_t start = text.find("o upper");
    ASSERT_NE(start, std::string::npos);
    write(file, text.replace(start, 7, "o " + name));
  }
  write("run/report.json", R"({"scene": "</script><script>alert(2)</script>"})");
  ASSERT_EQ(weft({"view", "run"}), 0) << err_;
  const std::string page = text_of(at("run/view.html"));
  EXPECT_EQ(page.find("<script>alert"), std::string::npos);
  const Json run = data("run/view.html").at("runs").at(0);
  EXPECT_EQ(run.at("topologies").at(0).at("cloths")[1].at("name"), name);
  EXPECT_EQ(run.at("facts").at("scene"), "</script><script>alert(2)</script>");
}

TEST_F(ViewSubcommand, BrokenReportsCostOnlyTheirFacts) {
  write("run/report.json", R"({"method": {"a": 1}, "device": "</script>", "wall_s": "long"})");
  write("run/steps.jsonl", "no step\n{\"number\": 1}\n");
  ASSERT_EQ(weft({"view", "run"}), 0) << err_;
  const Json facts = data("run/view.html").at("runs").at(0).at("facts");
  EXPECT_FALSE(facts.contains("method"));
  EXPECT_FALSE(facts.contains("wall_s"));
  EXPECT_EQ(facts.at("device"), "</script>");
  EXPECT_EQ(facts.at("steps").size(), 0u);
}

TEST_F(ViewSubcommand, RefusesInOneLine) {
  expect_refused({"nowhere"}, "nowhere");
  expect_refused({"run", "-o", "page.obj"}, "-o: page.obj; allowed: a file name");
  expect_refused({"run", "-o", "nowhere/page.html"}, "-o: nowhere/page.html (No such file");
  expect_refused({"run", "--frames", "7:"}, "--frames");
  expect_refused({"run", "--frames", "one"}, "--frames");
  expect_refused({"run", "--beside", "nowhere"}, "nowhere");
  write("run/frames/cloth_00002.obj", "v 0 0 zero\n");
  expect_refused({"run"}, "cloth_00002.obj");
}

TEST_F(ViewSubcommand, LiveRunsAreRefusedInOneLine) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases{
      {{"--live", "70000"}, "--live"},
      {{"--live", "seven"}, "--live"},
      {{"--live", "--method", "time_parallel"}, "time_parallel"},
      {{"--live", "--need", "intersections=0"}, "--need"}};
  for (const auto& [more, word] : cases) {
    EXPECT_EQ(run("watched", more), 2) << word;
    EXPECT_EQ(line_count(err_), 1) << err_;
    EXPECT_NE(err_.find(word), std::string::npos) << err_;
    EXPECT_FALSE(fs::exists(at("watched"))) << word;
  }
}

TEST_F(ViewSubcommand, WritesThroughNoLinkOfARun) {
  write("mine.txt", "mine");
  fs::create_symlink(at("mine.txt"), at("run/view.html"));
  expect_refused({"run"}, "a link");
  EXPECT_EQ(text_of(at("mine.txt")), "mine");
}

}  // namespace
}  // namespace weft::test
