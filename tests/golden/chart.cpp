// `weft chart`, `weft plan` and `weft run --need` as a user calls them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "tests/golden/process.hpp"

namespace weft::test {
namespace {

/// Falls through the void: the truth is a parabola.
const std::string falling_scene = R"({
  "name": "falling",
  "time": {"step": 0.01, "frame_rate": 25, "frames": 4},
  "materials": {"cotton": {"density": 0.15, "stretch_stiffness": 50, "bending_stiffness": 1e-5}},
  "cloths": [{"name": "sheet", "grid": {"size": [0.4, 0.4], "cells": [6, 6]}, "material": "cotton"}]
})";

class Chart : public Process {
 protected:
  void SetUp() override {
    Process::SetUp();
    write("falling.json", falling_scene);
  }
  Json chart(const std::string& scene) const {
    return Json::parse(text_of(at("charts") / scene / "chart.json"));
  }
  /// The point of a series.
  static Json point(const Json& chart, const std::string& series, const std::string& label) {
    for (const Json& p : chart.at("points"))
      if (p.at("series") == series && p.at("label") == label) return p;
    return nullptr;
  }
  const std::vector<std::string> quick_{
      "chart", "falling.json", "-o", "charts", "--quick", "--runs", "1", "--reference-steps", "2"};
};

std::ptrdiff_t count(const std::string& text, const std::string& part) {
  std::ptrdiff_t n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

bool has_gnuplot() {
  return std::system("command -v gnuplot >/dev/null 2>&1") == 0;
}

TEST_F(Chart, MeasuresAgainstTheParabola) {
  const int code = weft(quick_);
  ASSERT_EQ(code, has_gnuplot() ? 0 : 2) << err_;
  const Json c = chart("falling");
  EXPECT_NE(c.at("about").get<std::string>().find("parabola"), std::string::npos);
  // Implicit Euler after n steps: g h^2 n (n + 1) / 2, that is g h t / 2 beyond g t^2 / 2; root
  // mean square over 4 frames of 0.04 s; over the diagonal of 0.4 m by 0.4 m.
  const auto expected = [](double h) {
    double sum = 0;
    for (int k = 1; k <= 4; ++k) sum += std::pow(9.81 * h * 0.04 * k / 2, 2);
    return std::sqrt(sum / 4) / (0.4 * std::sqrt(2.0));
  };
  EXPECT_NEAR(point(c, "scene", "as it is").at("error").get<double>(), expected(0.01), 1e-5);
  EXPECT_NEAR(point(c, "time step", "0.005 s").at("error").get<double>(), expected(0.005), 1e-5);
  // Falling needs none of these.
  for (const char* label : {"no self-contact", "no friction"})
    EXPECT_EQ(point(c, "model", label).at("state_hash"),
              point(c, "scene", "as it is").at("state_hash"))
        << label;
  EXPECT_EQ(c.at("reference_limited"), false);
  const std::string page = text_of(at("charts/falling/chart.html"));
  EXPECT_NE(page.find("</html>"), std::string::npos);
  EXPECT_EQ(page.find("http://"), page.find("http://www.w3.org/2000/svg"));  // needs nothing else
  EXPECT_EQ(line_count(text_of(at("charts/falling/chart.csv"))),
            static_cast<std::ptrdiff_t>(c.at("points").size()) + 1);
}

TEST_F(Chart, GoesOnWhereItStopped) {
  weft(quick_);
  const Json first = chart("falling");
  weft(quick_);
  EXPECT_EQ(out_.find("error"), std::string::npos) << out_;  // nothing was measured again
  Json second = chart("falling");
  second["finished"] = first["finished"];
  EXPECT_EQ(first, second);
  // Half of the points are gone: only they are measured.
  std::string text = text_of(at("charts/falling/points.jsonl"));
  const auto lines = line_count(text);
  write("charts/falling/points.jsonl", text.substr(0, text.size() / 2));
  weft(quick_);
  EXPECT_GT(count(out_, ": error"), 1) << out_;
  EXPECT_LT(count(out_, ": error"), lines) << out_;
  EXPECT_EQ(chart("falling").at("points").size(), first.at("points").size());
}

TEST_F(Chart, SaysWhatBeginsAndEnds) {
  weft(quick_);
  // Free fall needs no BDF2: two runs for the limit, two for chaos.
  for (const char* line : {"falling: reference 1/4 begins  reference_implicit_euler_2\n",
                           "falling: reference 4/4 ends  0:00 left  chaos_shaken: "})
    EXPECT_NE(out_.find(line), std::string::npos) << out_;
  EXPECT_EQ(count(out_, "falling: reference "), 8) << out_;
  const auto points = static_cast<std::ptrdiff_t>(chart("falling").at("points").size());
  EXPECT_EQ(count(out_, " begins  "), 4 + points) << out_;
  EXPECT_EQ(count(out_, " ends  "), 4 + points) << out_;
  EXPECT_LT(out_.find("scene: as it is (implicit)\n"),
            out_.find("scene: as it is (implicit): error"));
  weft(quick_);
  EXPECT_EQ(count(out_, " begins  "), 0) << out_;
}

TEST_F(Chart, SideBySideIsTheSameChart) {
  weft(quick_);
  const Json first = chart("falling");
  auto arguments = quick_;
  arguments.insert(arguments.end(), {"--jobs", "2", "-o", "side_by_side"});
  arguments.erase(arguments.begin() + 2, arguments.begin() + 4);
  weft(arguments);
  const Json second = Json::parse(text_of(at("side_by_side/falling/chart.json")));
  int planned = 0;
  for (const Json& p : first.at("points")) {
    if (p.at("series") == "planned") {
      ++planned;
      continue;  // chosen by times
    }
    const Json other = point(second, p.at("series"), p.at("label"));
    ASSERT_TRUE(other.is_object()) << p.at("label");
    EXPECT_EQ(other.at("state_hash"), p.at("state_hash")) << p.at("label");
    EXPECT_EQ(other.at("error"), p.at("error")) << p.at("label");
  }
  EXPECT_GE(planned, 2);  // to 10 % and to 1 %
}

/// A chart of three points whose times and errors are given.
std::string made_chart(double seconds, double error) {
  const auto made = [](const char* series, double s, double e) {
    return Json{{"series", series},
                {"label", ""},
                {"method", "implicit"},
                {"device", "cpu:1"},
                {"overrides", Json::array()},
                {"command", "weft run"},
                {"commit", "c"},
                {"state_hash", series},
                {"failure", ""},
                {"seconds", {s, 1.1 * s}},
                {"error", e},
                {"statistics", nullptr},
                {"hausdorff", nullptr},
                {"curvature", nullptr},
                {"stretch", nullptr},
                {"drift", nullptr},
                {"intersections", 0}};
  };
  return Json{
      {"scene", "made"},
      {"about", "made"},
      {"reference_floor", 0.001},
      {"machine", "none"},
      {"finished", "never"},
      {"points",
       {made("scene", 1, 0.01), made("planned", 0.5, 0.02), made("time step", seconds, error)}}}
      .dump();
}

TEST_F(Chart, CheckFindsWhatBeatsTheDefaultAndThePlan) {
  struct Expected {
    double seconds, error;
    int code;
    const char* text;
  };
  for (const Expected& e :
       {Expected{2, 0.005, 0, ""}, Expected{0.8, 0.005, 4, "better than the scene's own"},
        Expected{0.95, 0.005, 0, ""},  // its slower run is not faster
        Expected{0.8, 0.0095, 0, ""},  // within the references' difference
        Expected{0.4, 0.015, 4, "above the front: planned"}, Expected{0.48, 0.015, 0, ""}}) {
    fs::create_directories(at("made"));
    write("made/chart.json", made_chart(e.seconds, e.error));
    EXPECT_EQ(weft({"chart", "--check", "made"}), e.code) << e.seconds << " " << e.error << out_;
    EXPECT_NE(out_.find(e.text), std::string::npos) << out_;
  }
  EXPECT_EQ(weft({"chart", "--check", "small.json"}), 2);
}

// After chaos, differences within two standard errors of the means over starts are chance.
TEST_F(Chart, CheckTellsDifferencesAfterChaosFromChance) {
  fs::create_directories(at("made"));
  for (const auto& [error, code] : {std::pair{0.001, 4}, std::pair{0.01, 0}}) {
    Json made = Json::parse(made_chart(0.8, 0.005));
    made["after_chaos"] = 0.75;
    for (Json& p : made["points"]) {
      p["statistics"] = p["series"] == "scene" ? 0.03 : 0.02;
      p["statistics_error"] = error;
    }
    write("made/chart.json", made.dump());
    EXPECT_EQ(weft({"chart", "--check", "made"}), code) << error << out_;
  }
}

// Without the scene's own settings there is nothing that others could be compared with.
TEST_F(Chart, CheckRefusesAChartWithoutTheScenesOwnPoint) {
  Json made = Json::parse(made_chart(2, 0.005));
  made["points"][0]["failure"] = "not finite";
  fs::create_directories(at("made"));
  write("made/chart.json", made.dump());
  EXPECT_EQ(weft({"chart", "--check", "made"}), 4);
  EXPECT_NE(out_.find("have no error and time: not finite"), std::string::npos) << out_;
  made["points"].erase(0);
  write("made/chart.json", made.dump());
  EXPECT_EQ(weft({"chart", "--check", "made"}), 2) << out_;
  EXPECT_NE(err_.find("made: points: none of the scene's own settings"), std::string::npos) << err_;
  EXPECT_EQ(line_count(err_), 1) << err_;
}

TEST_F(Chart, ShowsPeersKnobsAndFailures) {
  write("peers.csv", "name,error,seconds\nother,0.01,3.5\n");
  auto arguments = quick_;
  arguments.insert(arguments.end(),
                   {"--peers", "peers.csv", "--knob", "solver.max_iterations=0,50"});
  weft(arguments);
  const Json c = chart("falling");
  EXPECT_EQ(point(c, "peer", "other").at("error"), 0.01);
  EXPECT_EQ(point(c, "solver.max_iterations", "50").at("failure"), "");
  const std::string failure = point(c, "solver.max_iterations", "0").at("failure");
  EXPECT_NE(failure.find("solver.max_iterations"), std::string::npos) << failure;
  write("bad.csv", "name,error\nother,0.01\n");
  arguments = quick_;
  arguments.insert(arguments.end(), {"--peers", "bad.csv"});
  EXPECT_EQ(weft(arguments), 2);
  EXPECT_NE(err_.find("bad.csv: line 1"), std::string::npos) << err_;
}

class Plan : public Chart {};

TEST_F(Plan, SaysWhatIsNeeded) {
  ASSERT_EQ(weft({"plan", "small.json", "--probe", "0.2", "--json", "plan.json"}), 0) << err_;
  const Json plan = Json::parse(text_of(at("plan.json")));
  for (const Json& s : plan.at("stages")) {
    const Json expected = s.at("stage") == "wind"       ? "left out"
                          : s.at("stage") == "friction" ? "needed"
                                                        : s.at("verdict");
    EXPECT_EQ(s.at("verdict"), expected) << s.at("stage");
  }
  EXPECT_GE(plan.at("devices").size(), 1);
  const Json& choice = plan.at("auto");
  EXPECT_FALSE(choice.at("reason").get<std::string>().empty());
  EXPECT_NE(out_.find("--device auto: " + choice.at("device").get<std::string>() + "; " +
                      choice.at("reason").get<std::string>()),
            std::string::npos)
      << out_;
  const bool cpu = choice.at("device").get<std::string>().starts_with("cpu:");
  EXPECT_EQ(choice.at("estimates").empty(), cpu) << choice;
  EXPECT_NE(out_.find("the same result for the least time: weft run small.json"), std::string::npos)
      << out_;
}

// Bending is left out only where it was measured to change less than half of what the target
// allows.
TEST_F(Plan, LeavesOutBendingWithinTheNeedAlone) {
  // Falls flat: bending does nothing at all.
  ASSERT_EQ(
      weft({"plan", "falling.json", "--probe", "0", "--need", "error<1%", "--json", "p.json"}), 0)
      << err_;
  EXPECT_NE(out_.find("within target"), std::string::npos) << out_;
  EXPECT_NE(out_.find("a result within the target for the least time"), std::string::npos) << out_;
  EXPECT_NE(out_.find("--set model.bending=false"), std::string::npos) << out_;
  // Held along one side, and stiff.
  Json stiff = Json::parse(falling_scene);
  stiff["materials"]["cotton"]["bending_stiffness"] = 0.01;
  stiff["pins"] = Json::array({{{"cloth", "sheet"}, {"edge", "left"}}});
  stiff["time"]["frames"] = 8;
  write("stiff.json", stiff.dump());
  ASSERT_EQ(weft({"plan", "stiff.json", "--probe", "0", "--need", "error<1%"}), 0) << err_;
  EXPECT_EQ(out_.find("model.bending=false"), std::string::npos) << out_;
  EXPECT_NE(out_.find("the target allows 0.5 %"), std::string::npos) << out_;
  // Without a target nothing is measured.
  ASSERT_EQ(weft({"plan", "stiff.json", "--probe", "0"}), 0) << err_;
  EXPECT_EQ(out_.find("the target allows"), std::string::npos) << out_;
  EXPECT_EQ(weft({"plan", "stiff.json", "--need", "speed<3"}), 2);
}

// A sheet that swings down: the error falls with the step, and a step is borne that is within 1 %.
TEST_F(Plan, SaysWhichStepsTheSceneBears) {
  Json swing = Json::parse(falling_scene);
  swing["pins"] = Json::array({{{"cloth", "sheet"}, {"edge", "left"}}});
  swing["time"] = {{"step", 0.01}, {"frame_rate", 25}, {"frames", 6}};
  write("swing.json", swing.dump());
  ASSERT_EQ(weft({"plan", "swing.json", "--probe", "0", "--steps", "--json", "p.json"}), 0) << err_;
  const Json steps = Json::parse(text_of(at("p.json"))).at("time_steps");
  EXPECT_EQ(steps.at("unknown"), "");
  EXPECT_LT(steps.at("chance"), 1e-3);
  const Json& trials = steps.at("trials");
  ASSERT_EQ(trials.size(), 4u);
  double longest_good = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_NEAR(trials[k].at("step").get<double>(), 0.04 / std::pow(2, k), 1e-9);
    if (k > 0) {
      EXPECT_LT(trials[k].at("error"), trials[k - 1].at("error"));
    }
    if (longest_good == 0 && trials[k].at("error") <= 0.01) longest_good = trials[k].at("step");
  }
  EXPECT_GT(longest_good, 0) << steps;
  EXPECT_EQ(steps.at("bears"), longest_good);
  EXPECT_NE(out_.find("the scene bears steps of"), std::string::npos) << out_;
  // Nothing is borne to an error that only the finest step has.
  ASSERT_EQ(weft({"plan", "swing.json", "--probe", "0", "--steps", "--need", "error<0.000001%"}), 0)
      << err_;
  EXPECT_NE(out_.find("the scene bears none of these steps"), std::string::npos) << out_;
}

// What the plan leaves out by a setting changes no bit.
TEST_F(Plan, LeavingOutChangesNothing) {
  ASSERT_EQ(weft({"plan", "falling.json", "--probe", "0", "--set", "contact.self=false"}), 0);
  EXPECT_NE(out_.find("--set model.friction=false"), std::string::npos) << out_;
  ASSERT_EQ(weft({"run", "falling.json", "--device", "cpu:1", "-o", "with", "--set",
                  "contact.self=false"}),
            0);
  ASSERT_EQ(weft({"run", "falling.json", "--device", "cpu:1", "-o", "without", "--set",
                  "contact.self=false", "--set", "model.friction=false"}),
            0);
  EXPECT_EQ(hash("with"), hash("without"));
}

/// Shipped scenes with and without all that their plans leave out.
TEST_F(Plan, SlowLeavingOutChangesNoShippedScene) {
  int scenes = 0;
  for (const auto& entry : fs::directory_iterator(WEFT_SOURCE_DIR "/scenes")) {
    const std::string scene = entry.path().string();
    if (entry.path().extension() != ".json" || scene.ends_with(".schema.json")) continue;
    const int code = weft({"plan", scene, "--probe", "0", "--json", "plan.json"});
    if (code == 2 && err_.find("assimp-testmodels") != std::string::npos) continue;
    ASSERT_EQ(code, 0) << scene << ": " << err_;
    std::vector<std::string> with{"run", scene,          "--device",    "cpu:1", "--frames",
                                  "1",   "--no-preview", "--overwrite", "-o",    "with"};
    std::vector<std::string> without = with;
    without.back() = "without";
    const Json plan = Json::parse(text_of(at("plan.json")));
    for (const Json& s : plan.at("stages"))
      if (s.at("verdict") == "left out" && s.at("off") != "")
        without.insert(without.end(), {"--set", s.at("off")});
    ASSERT_GT(without.size(), with.size()) << scene;
    ASSERT_EQ(weft(with), 0) << scene << ": " << err_;
    ASSERT_EQ(weft(without), 0) << scene << ": " << err_;
    EXPECT_EQ(hash("with"), hash("without")) << scene;
    ++scenes;
  }
  EXPECT_GT(scenes, 10);
}

/// What plan, chart and need say of the scene of a sweep that is there.
class CommittedCharts : public Process {
 protected:
  static std::vector<fs::path> folders() {
    std::vector<fs::path> found;
    for (const auto& entry :
         fs::recursive_directory_iterator(WEFT_SOURCE_DIR "/benchmarks/results/charts"))
      if (entry.path().filename() == "chart.json") found.push_back(entry.path().parent_path());
    std::sort(found.begin(), found.end());
    return found;
  }
};

// No default is beaten in both speed and accuracy, except in the chart that docs/accuracy.md names,
// and plans choose points on the front.
TEST_F(CommittedCharts, NothingBeatsDefaultsOrPlans) {
  if (folders().empty()) GTEST_SKIP() << "no chart is committed: NOT TESTED";
  for (const fs::path& folder : folders()) {
    const bool beaten = folder.filename() == "tablecloth_gpu";
    EXPECT_EQ(weft({"chart", "--check", folder.string()}), beaten ? 4 : 0) << out_ << err_;
    if (!beaten) continue;
    EXPECT_GE(line_count(out_), 1);
    std::istringstream lines(out_);
    const std::regex known("solver tolerance[:,] 0\\.1 ");  // as a point, and as the plan's choice
    for (std::string line; std::getline(lines, line);)
      EXPECT_TRUE(std::regex_search(line, known)) << line;
  }
}

TEST_F(CommittedCharts, HaveTheirPictures) {
  if (folders().empty()) GTEST_SKIP() << "no chart is committed: NOT TESTED";
  for (const fs::path& folder : folders()) {
    const std::string picture = text_of(folder / "chart.svg");
    EXPECT_NE(picture.find("</svg>"), std::string::npos) << folder;
    EXPECT_LT(picture.size(), 200'000u) << folder;
  }
}

/// The same sheet, whose triangles can be chosen, so that the error of the mesh can be told.
std::string open_falling_scene() {
  std::string scene = falling_scene;
  const std::string cells = ", \"cells\": [6, 6]";
  scene.erase(scene.find(cells), cells.size());
  return scene.insert(scene.find('{') + 1, "\"triangles\": 400, ");
}

TEST_F(Plan, NeedIsMetByRefining) {
  write("open.json", open_falling_scene());
  // At 0.01 s the error is about 0.95 %, half of that at half the step.
  ASSERT_EQ(
      weft({"run", "open.json", "-o", "a", "--no-preview", "--need", "error<0.6%,intersections=0"}),
      0)
      << out_ << err_;
  const Json need = Json::parse(text_of(at("a/need.json")));
  EXPECT_EQ(need.at("met"), true);
  EXPECT_LT(need.at("error").get<double>(), 0.006);
  EXPECT_EQ(report("a").at("steps"), 32);  // 0.005 s
  EXPECT_FALSE(fs::exists(at("a/need")));
  EXPECT_TRUE(fs::exists(at("a/frames/cloth_00004.obj")));
}

TEST_F(Plan, NeedThatIsNotMetIsAFailure) {
  write("open.json", open_falling_scene());
  EXPECT_EQ(weft({"run", "open.json", "-o", "a", "--no-preview", "--need", "error<1e-6"}), 4);
  EXPECT_NE(err_.find("target not met: error about"), std::string::npos) << err_;
  EXPECT_EQ(Json::parse(text_of(at("a/need.json"))).at("met"), false);
  EXPECT_EQ(weft({"run", "falling.json", "--need", "speed<3"}), 2);
  EXPECT_NE(err_.find("error<NUMBER"), std::string::npos) << err_;
}

TEST_F(Plan, NeedStartsFromTheChart) {
  weft(quick_);
  write("open.json", open_falling_scene());
  ASSERT_EQ(weft({"run", "open.json", "-o", "a", "--no-preview", "--need", "error<3%", "--chart",
                  "charts/falling"}),
            0)
      << out_ << err_;
  EXPECT_NE(out_.find("from the chart: "), std::string::npos) << out_;
}

}  // namespace
}  // namespace weft::test
