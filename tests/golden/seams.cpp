// What `weft run` says of seams that are open at the end, and its exit codes.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/golden/process.hpp"

namespace weft::test {
namespace {

/// Two panels held apart by pins, with a seam that cannot close and one that closes at once.
/// @param of_first keys of the first seam
std::string held_apart(const std::string& of_first) {
  return R"({
    "name": "held", "device": "cpu",
    "time": {"step": 0.01, "frame_rate": 50, "frames": 3},
    "materials": {"cotton": {"density": 0.15}},
    "gravity": [0, 0, 0],
    "cloths": [
      {"name": "left", "material": "cotton", "grid": {"size": [0.2, 0.2], "cells": [2, 2]}},
      {"name": "right", "material": "cotton", "grid": {"size": [0.2, 0.2], "cells": [2, 2]},
       "transform": {"translate": [0.25, 0, 0]}},
      {"name": "other", "material": "cotton", "grid": {"size": [0.2, 0.2], "cells": [2, 2]},
       "transform": {"translate": [-0.2005, 0, 0]}}],
    "pins": [{"cloth": "left", "vertices": [2, 5, 8]}, {"cloth": "right", "vertices": [0, 3, 6]}],
    "seams": [
      {"between": [{"cloth": "left", "edge": "right"}, {"cloth": "right", "edge": "left"}],
       "ramp_time": 0)" +
         of_first + R"(},
      {"between": [{"cloth": "other", "edge": "right"}, {"cloth": "left", "edge": "left"}]}]
  })";
}

class OpenSeams : public Process {
 protected:
  int run_with(const std::string& of_first, const std::vector<std::string>& more = {}) {
    write("held.json", held_apart(of_first));
    std::vector<std::string> words{"run", "held.json", "-o", "a", "--no-preview", "--overwrite"};
    words.insert(words.end(), more.begin(), more.end());
    return weft(words);
  }
  bool says(const std::string& text) const { return err_.find(text) != std::string::npos; }
};

TEST_F(OpenSeams, ThatShouldHaveClosedFail) {
  EXPECT_EQ(run_with(""), 4) << err_;
  EXPECT_EQ(line_count(err_), 1) << err_;
  EXPECT_TRUE(
      says("seam not closed: seams[0] (\"left\" to \"right\") has 3 of 3 pairs open, the "
           "largest gap is 0.05 m"))
      << err_;
  EXPECT_TRUE(says("checkpoint")) << err_;
  const Json report = this->report("a");
  EXPECT_EQ(report.at("frames"), 3);
  EXPECT_TRUE(report.contains("failure"));
  const Json seams = report.at("seams");
  ASSERT_EQ(seams.size(), 2u);
  EXPECT_EQ(seams[0].at("seam"), 0);
  EXPECT_EQ(seams[0].at("cloths"), (Json{"left", "right"}));
  EXPECT_EQ(seams[0].at("pairs"), 3);
  EXPECT_EQ(seams[0].at("open"), 3);
  EXPECT_NEAR(seams[0].at("largest_gap"), 0.05, 1e-6);
  EXPECT_EQ(seams[0].at("closed_at"), nullptr);
  EXPECT_EQ(seams[1].at("open"), 0);
  EXPECT_EQ(seams[1].at("largest_gap"), 0);
  EXPECT_EQ(seams[1].at("closed_at"), 0);
}

TEST_F(OpenSeams, ThatMayStayOpenWarn) {
  EXPECT_EQ(run_with(R"(, "may_stay_open": true)"), 0) << err_;
  EXPECT_EQ(line_count(err_), 1) << err_;
  EXPECT_TRUE(says("warning: not closed at the end: seams[0]")) << err_;
  EXPECT_FALSE(report("a").contains("failure"));
}

TEST_F(OpenSeams, OfARunCutShortWarn) {
  EXPECT_EQ(run_with("", {"--frames", "2"}), 0) << err_;
  EXPECT_TRUE(says("warning: not closed at the end: seams[0]")) << err_;
  // Going on to the scene's own end fails.
  EXPECT_EQ(weft({"run", "held.json", "-o", "a", "--no-preview", "--resume", "latest"}), 4) << err_;
}

TEST_F(OpenSeams, WhoseSpringsStillGrowWarn) {
  EXPECT_EQ(run_with(R"(, "start_time": 0.061)"), 0) << err_;
  EXPECT_TRUE(says("warning: not closed at the end: seams[0]")) << err_;
}

TEST_F(OpenSeams, ThatNeverWeldWarn) {
  EXPECT_EQ(run_with(R"(, "weld_distance": 0)"), 0) << err_;
  EXPECT_TRUE(says("warning: not closed at the end: seams[0]")) << err_;
}

}  // namespace
}  // namespace weft::test
