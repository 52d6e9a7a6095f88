// Runs with steps of automatic length: their files, what they are resumed from, and what refuses
// them.
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

#include "tests/golden/process.hpp"

namespace weft::test {
namespace {

class AutomaticRun : public Process {
 protected:
  const std::vector<std::string> automatic_{"--set", "time.step=auto"};

  std::vector<std::string> with(std::vector<std::string> more) const {
    more.insert(more.end(), automatic_.begin(), automatic_.end());
    return more;
  }
  std::vector<Json> steps(const std::string& output) const {
    std::vector<Json> all;
    std::istringstream lines(text_of(at(output) / "steps.jsonl"));
    for (std::string line; std::getline(lines, line);) all.push_back(Json::parse(line));
    return all;
  }
  void expect_refused(const std::vector<std::string>& arguments, const std::string& field) {
    EXPECT_EQ(weft(arguments), 2) << err_;
    EXPECT_EQ(line_count(err_), 1) << err_;
    EXPECT_NE(err_.find(field), std::string::npos) << err_;
  }
};

TEST_F(AutomaticRun, ReportsItsSteps) {
  ASSERT_EQ(run("a", with({})), 0) << err_;
  EXPECT_NE(out_.find("  steps of 0.0"), std::string::npos) << out_;
  const Json whole = report("a");
  const std::vector<Json> all = steps("a");
  EXPECT_EQ(whole["frames"], 6);
  EXPECT_EQ(whole["simulated_s"], 6 / 25.0);
  EXPECT_EQ(whole["steps"], all.size());
  double shortest = 1, longest = 0, error = 0, before = 0;
  int rejected = 0, frame_ends = 0;
  for (const Json& step : all) {
    const auto length = step["step"].get<double>();
    EXPECT_NEAR(step["time"].get<double>(), before + length, 1e-12);
    before = step["time"].get<double>();
    shortest = std::min(shortest, length);
    longest = std::max(longest, length);
    error = std::max(error, step["step_error"].get<double>());
    rejected += step["rejected"].get<int>();
    frame_ends += step.contains("energy") ? 1 : 0;
  }
  EXPECT_EQ(frame_ends, 6);
  EXPECT_LT(shortest, longest);
  const Json expected{
      {"shortest", shortest}, {"longest", longest}, {"error_max", error}, {"rejected", rejected}};
  EXPECT_EQ(whole["time_steps"], expected);
  ASSERT_EQ(run("b", {"--frames", "1"}), 0) << err_;
  EXPECT_FALSE(report("b").contains("time_steps"));
  EXPECT_FALSE(steps("b").front().contains("step_error"));
  EXPECT_EQ(out_.find("steps of"), std::string::npos) << out_;
  // The resolved scene, run again.
  ASSERT_EQ(weft({"run", "a/scene.json", "-o", "c", "--no-preview"}), 0) << err_;
  EXPECT_EQ(hash("c"), hash("a"));
}

TEST_F(AutomaticRun, IsResumedAndSharedBitForBit) {
  ASSERT_EQ(run("a", with({"--device", "cpu:1"})), 0) << err_;
  ASSERT_EQ(run("b", with({"--device", "cpu:2"})), 0) << err_;
  EXPECT_EQ(hash("b"), hash("a"));
  ASSERT_EQ(run("b", with({"--device", "cpu:3", "--resume", "b/checkpoint_00004.weft"})), 0)
      << err_;
  EXPECT_EQ(err_, "");
  EXPECT_EQ(hash("b"), hash("a"));
  EXPECT_EQ(steps("b").size(), steps("a").size());
  for (const char* key : {"time_steps", "contacts", "frames", "steps", "simulated_s"})
    EXPECT_EQ(report("b")[key], report("a")[key]) << key;
  EXPECT_EQ(text_of(at("a/frames/cloth_00006.obj")), text_of(at("b/frames/cloth_00006.obj")));
}

TEST_F(AutomaticRun, IsRefusedWithAnotherStep) {
  ASSERT_EQ(run("a", with({"--frames", "2"})), 0) << err_;
  expect_refused(run_arguments("b", {"--resume", "a/checkpoint_00002.weft"}), "time.step");
  expect_refused(run_arguments("b", {"--resume", "a/checkpoint_00002.weft", "--set",
                                     "time.step=auto", "--set", "time.tolerance=0.1"}),
                 "time.tolerance");
}

TEST_F(AutomaticRun, WhatTriesOtherStepsRefusesIt) {
  expect_refused({"chart", "small.json", "--set", "time.step=auto"}, "time.step");
  expect_refused(run_arguments("a", with({"--need", "error<5%"})), "time.step");
  expect_refused(run_arguments("a", with({"--set", "method.type=time_parallel"})), "time.step");
  EXPECT_FALSE(fs::exists(at("a")));
  ASSERT_EQ(weft({"plan", "small.json", "--set", "time.step=auto", "--probe", "0.1", "--steps"}), 0)
      << err_;
  EXPECT_NE(out_.find("time steps of 0.00"), std::string::npos) << out_;
  EXPECT_NE(out_.find("not tried: time.step is auto"), std::string::npos) << out_;
}

}  // namespace
}  // namespace weft::test
