// Runs that end at rest, at a time limit, and that leave the last frame alone.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "tests/golden/process.hpp"
#include "weft/core/vec.hpp"

namespace weft::test {
namespace {

/// A cloth that lies down on a floor within a second or so.
const std::string rest_scene = R"({
  "name": "rest", "device": "cpu",
  "time": {"step": 0.01, "frame_rate": 25, "frames": 200, "until": "rest"},
  "materials": {"cotton": {"density": 0.2, "stretch_stiffness": 300, "bending_stiffness": 1e-5,
                           "damping": {"stiffness": 5e-3, "mass": 2}}},
  "cloths": [{"name": "sheet", "grid": {"size": [0.2, 0.2], "cells": [6, 6]}, "material": "cotton",
              "transform": {"translate": [0, 0, 0.06]}}],
  "obstacles": [{"name": "floor", "box": {"size": [1, 1, 0.1], "cells": [2, 2, 1]}}],
  "output": {"checkpoint_every": 5}
})";

class UntilRest : public Process {
 protected:
  void SetUp() override { write("rest.json", rest_scene); }

  int run(const std::string& output, const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments{"run", "rest.json", "-o", output, "--no-preview"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return weft(arguments);
  }
  Json report(const std::string& run) const {
    return Json::parse(std::ifstream(at(run + "/report.json")));
  }
  /// Of the sheet at the end of a frame.
  std::vector<Vec3<double>> vertices(const std::string& run, int frame) const {
    char name[32];
    std::snprintf(name, sizeof name, "cloth_%05d.obj", frame);
    std::ifstream file(at(run + "/frames/" + name));
    std::vector<Vec3<double>> x;
    for (std::string line; std::getline(file, line);) {
      Vec3<double> p;
      if (std::sscanf(line.c_str(), "v %lf %lf %lf", &p[0], &p[1], &p[2]) == 3) x.push_back(p);
    }
    return x;
  }
  std::vector<std::string> frames(const std::string& run) const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(at(run + "/frames")))
      names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
  }
};

TEST_F(UntilRest, EndsOnceQuietFramesSayThatItRests) {
  ASSERT_EQ(run("a"), 0) << err_;
  const Json a = report("a");
  EXPECT_EQ(a["rested"], true);
  const int last = a["frames"];
  EXPECT_LT(last, 200);
  EXPECT_DOUBLE_EQ(a["rested_at_s"], last / 25.0);
  EXPECT_NE(out_.find("rested at "), std::string::npos) << out_;
  // Five frames in a row, and no earlier ones: 0.2 s at 25 frames per second. In a frame at most 5
  // % of the vertices move, and at most 1.5 % are 2 mm from where they were before the five.
  std::vector<double> shares;
  std::ifstream lines(at("a/steps.jsonl"));
  for (std::string line; std::getline(lines, line);)
    if (const Json step = Json::parse(line); step.contains("moving_share"))
      shares.push_back(step["moving_share"]);
  ASSERT_EQ(shares.size(), static_cast<std::size_t>(last));
  ASSERT_GE(last, 6);
  int quiet = 0;
  std::vector<Vec3<double>> since;
  for (int frame = 2; frame <= last; ++frame) {
    if (quiet == 0) since = vertices("a", frame - 1);
    const std::vector<Vec3<double>> x = vertices("a", frame);
    double displaced = 0;
    for (std::size_t v = 0; v < x.size(); ++v) displaced += length(x[v] - since[v]) > 0.002 ? 1 : 0;
    const bool still = shares[static_cast<std::size_t>(frame - 1)] <= 0.05 &&
                       displaced <= 0.015 * static_cast<double>(x.size());
    quiet = still ? quiet + 1 : 0;
    EXPECT_EQ(quiet >= 5, frame == last) << frame;
  }
}

TEST_F(UntilRest, TheSameOnMoreThreadsAndAfterResuming) {
  ASSERT_EQ(run("a"), 0) << err_;
  ASSERT_EQ(run("b", {"--device", "cpu:3"}), 0) << err_;
  EXPECT_EQ(report("b")["frames"], report("a")["frames"]);
  EXPECT_EQ(report("b")["state_hash"], report("a")["state_hash"]);
  // In the midst of the quiet frames, whose count the checkpoint holds.
  const int last = report("a")["frames"];
  const std::string part = std::to_string(last - 2);
  ASSERT_EQ(run("c", {"--frames", part}), 0) << err_;
  EXPECT_EQ(report("c")["rested"], false);
  EXPECT_NE(out_.find("did not rest within " + part + " frames"), std::string::npos) << out_;
  ASSERT_EQ(run("c", {"--resume", "latest"}), 0) << err_;
  EXPECT_EQ(report("c")["frames"], last);
  EXPECT_EQ(report("c")["state_hash"], report("a")["state_hash"]);
  EXPECT_EQ(report("c")["rested"], true);
  // Nothing is left to do.
  ASSERT_EQ(run("c", {"--resume", "latest"}), 0) << err_;
  EXPECT_EQ(report("c")["state_hash"], report("a")["state_hash"]);
}

TEST_F(UntilRest, WaitsForWhatTheSceneHasPlanned) {
  ASSERT_EQ(run("a", {"--set", R"(pins=[{"cloth": "sheet", "vertices": [0], "release_time": 3}])"}),
            0)
      << err_;
  EXPECT_EQ(report("a")["rested"], true);
  EXPECT_GE(report("a")["frames"], 3 * 25 + 5);
}

TEST_F(UntilRest, LeavesTheLastFrameAlone) {
  ASSERT_EQ(run("all"), 0) << err_;
  const int last = report("all")["frames"];
  char name[32];
  std::snprintf(name, sizeof name, "cloth_%05d", last);
  ASSERT_EQ(run("a", {"--set", "output.frames=last"}), 0) << err_;
  const std::vector<std::string> left{std::string(name) + ".obj", "obstacle.obj"};
  EXPECT_EQ(frames("a"), left);
  const auto bytes = [&](const std::string& folder) {
    std::ifstream file(at(folder + "/frames/" + name + ".obj"));
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  EXPECT_EQ(bytes("a"), bytes("all"));
  EXPECT_EQ(weft({"check", "a"}), 0) << out_;
  // Stopped on the way, and gone on with: the frame of the stop goes.
  ASSERT_EQ(run("b", {"--set", "output.frames=last", "--frames", "7"}), 0) << err_;
  ASSERT_EQ(run("b", {"--set", "output.frames=last", "--resume", "latest"}), 0) << err_;
  EXPECT_EQ(frames("b"), left);
  for (const std::string format : {"ply", "pc2", "usda", "glb"}) {
    ASSERT_EQ(run(format, {"--set", "output.frames=last", "--set", "output.format=" + format}), 0)
        << err_;
    EXPECT_EQ(weft({"check", format}), 0) << out_ << err_;
    EXPECT_NE(out_.find("1 frame checked"), std::string::npos) << out_;
  }
}

TEST_F(UntilRest, TimeLimitEndsAsASignalDoes) {
  EXPECT_EQ(run("a", {"--time-limit", "0.5", "--set", "time.until=frames", "--set",
                      "time.frames=100000", "--set", "obstacles=[]", "--set", "gravity=[0,0,0]",
                      "--set", "output.frames=last"}),
            130);
  EXPECT_NE(err_.find("weft: stopped by the time limit of 0.5 s; checkpoint a/checkpoint_"),
            std::string::npos)
      << err_;
  EXPECT_EQ(report("a")["failure"], "stopped by the time limit of 0.5 s");
  EXPECT_EQ(run("b", {"--time-limit", "0"}), 2);
  EXPECT_NE(err_.find("--time-limit"), std::string::npos) << err_;
}

TEST_F(UntilRest, SlicesOfTimeHaveNoRest) {
  EXPECT_EQ(run("a", {"--method", "time_parallel"}), 2);
  EXPECT_NE(err_.find("time.until: \"rest\" with the method \"time_parallel\"; allowed: "),
            std::string::npos)
      << err_;
}

/// Wavefront text of a tube about the z axis.
std::string tube(double radius, double low, double high, double aside, bool closed) {
  constexpr int around = 16, rings = 25;
  std::string text;
  for (int r = 0; r < rings; ++r)
    for (int k = 0; k < around; ++k) {
      const double a = 2 * 3.14159265358979 * k / around;
      text += "v " + std::to_string(aside + radius * std::cos(a)) + " " +
              std::to_string(radius * std::sin(a)) + " " +
              std::to_string(low + (high - low) * r / (rings - 1)) + "\n";
    }
  const auto number = [](int r, int k) { return std::to_string(r * around + k % around + 1); };
  for (int r = 0; r + 1 < rings; ++r)
    for (int k = 0; k < around; ++k)
      text += "f " + number(r, k) + " " + number(r, k + 1) + " " + number(r + 1, k + 1) + "\nf " +
              number(r, k) + " " + number(r + 1, k + 1) + " " + number(r + 1, k) + "\n";
  for (int k = 1; closed && k + 1 < around; ++k)
    text += "f " + number(0, 0) + " " + number(0, k + 1) + " " + number(0, k) + "\nf " +
            number(rings - 1, 0) + " " + number(rings - 1, k) + " " + number(rings - 1, k + 1) +
            "\n";
  return text;
}

TEST_F(UntilRest, CheckSaysWhetherAGarmentIsWorn) {
  write("post.obj", tube(0.1, 0, 1.6, 0, true));
  write("start.obj", tube(0.16, 0.9, 1.2, 0, false));
  write("worn.obj", tube(0.14, 0.88, 1.18, 0, false));
  write("low.obj", tube(0.14, 0.3, 0.6, 0, false));
  write("beside.obj", tube(0.14, 0.88, 1.18, 0.6, false));
  const std::vector<std::string> with{"--worn", "--obstacle", "post.obj"};
  const auto check = [&](const std::string& mesh, std::vector<std::string> more) {
    std::vector<std::string> arguments{"check", mesh};
    arguments.insert(arguments.end(), with.begin(), with.end());
    arguments.insert(arguments.end(), more.begin(), more.end());
    return weft(arguments);
  };
  EXPECT_EQ(check("worn.obj", {"--start", "start.obj"}), 0) << out_ << err_;
  EXPECT_NE(out_.find("worn.obj: garment cloth: worn\n"), std::string::npos) << out_;
  EXPECT_EQ(out_.find("the start is not known"), std::string::npos) << out_;
  EXPECT_EQ(check("worn.obj", {}), 0) << out_ << err_;
  EXPECT_NE(out_.find("worn.obj: the start is not known"), std::string::npos) << out_;
  EXPECT_EQ(check("low.obj", {"--start", "start.obj"}), 1) << out_;
  EXPECT_NE(out_.find("low.obj: garment cloth: opening at cloth: has slid 0."), std::string::npos)
      << out_;
  EXPECT_EQ(check("beside.obj", {"--json"}), 1);
  const Json json = Json::parse(out_)["worn"];
  ASSERT_EQ(json.size(), 1u);
  EXPECT_EQ(json[0]["worn"], false);
  EXPECT_EQ(json[0]["openings"].size(), 2u);
  EXPECT_EQ(json[0]["openings"][0]["around"], "nothing");
  EXPECT_EQ(weft({"check", "worn.obj", "--worn"}), 2);
  EXPECT_NE(err_.find("--worn: no obstacle; allowed: "), std::string::npos) << err_;
  EXPECT_EQ(check("worn.obj", {"--body", "nobody"}), 2);
  EXPECT_NE(err_.find("--body: nobody; allowed: one of body"), std::string::npos) << err_;
  EXPECT_EQ(check("worn.obj", {"--start", "post.obj", "--segmentation", "none.json"}), 2);
  write("parts.json", R"({"left_arm": [0, 100000]})");
  EXPECT_EQ(check("worn.obj", {"--segmentation", "parts.json"}), 2);
  EXPECT_NE(err_.find("parts.json: left_arm: 100000; allowed: "), std::string::npos) << err_;
  EXPECT_EQ(weft({"check", "worn.obj", "--body", "body"}), 2);
}

TEST_F(UntilRest, WhatIsNotWholeOrDoesNotRestIsNotWorn) {
  write("post.obj", tube(0.1, 0, 1.6, 0, true));
  write("skirt.obj", tube(0.16, 0.9, 1.2, 0, false));
  Json scene = Json::parse(rest_scene);
  scene["cloths"] = {
      {{"name", "skirt"}, {"mesh", "skirt.obj"}, {"material", "cotton"}, {"rest", "initial"}}};
  scene["obstacles"] = {{{"name", "post"}, {"mesh", "post.obj"}}};
  scene["pins"] = {{{"cloth", "skirt"}, {"vertices", Json::array()}}};
  for (int v = 384; v < 400; ++v) scene["pins"][0]["vertices"].push_back(v);
  write("rest.json", scene.dump());
  ASSERT_EQ(run("whole"), 0) << err_;
  EXPECT_EQ(weft({"check", "whole", "--worn"}), 0) << out_ << err_;
  ASSERT_EQ(run("part", {"--frames", "2"}), 0) << err_;
  EXPECT_EQ(weft({"check", "part", "--worn"}), 1) << out_ << err_;
  EXPECT_NE(out_.find("garment skirt: has not come to rest\n"), std::string::npos) << out_;
  EXPECT_EQ(weft({"check", "part"}), 0) << out_ << err_;
  ASSERT_EQ(run("stopped", {"--time-limit", "0.5", "--set", "time.until=frames", "--set",
                            "time.frames=100000", "--set", "output.frames=last"}),
            130)
      << err_;
  EXPECT_EQ(weft({"check", "stopped", "--worn", "--json"}), 1) << out_ << err_;
  const Json stopped = Json::parse(out_)["worn"][0];
  EXPECT_EQ(stopped["worn"], false);
  EXPECT_EQ(stopped["faults"].back(), "the run is not whole: stopped by the time limit of 0.5 s");
}

TEST_F(UntilRest, TheReportSaysWhatHandlesBear) {
  Json scene = Json::parse(rest_scene);
  scene.erase("obstacles");
  scene["handles"] = {{{"cloth", "sheet"}, {"edge", "top"}}};
  write("rest.json", scene.dump());
  ASSERT_EQ(run("a"), 0) << err_;
  const Json handles = report("a")["handles"];
  ASSERT_EQ(handles.size(), 1u);
  EXPECT_EQ(handles[0]["cloth"], "sheet");
  EXPECT_NEAR(handles[0]["weight_share"], 1, 0.05);
  EXPECT_NEAR(handles[0]["force_n"][2], 0.2 * 0.2 * 0.2 * 9.81, 0.05 * 0.0785);
}

}  // namespace
}  // namespace weft::test
