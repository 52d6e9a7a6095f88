// Scenes that start intersecting, through the program.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/golden/process.hpp"

namespace weft::test {
namespace {

/// Two sheets that cross, over a ball that the lower one runs through.
const std::string tangled_scene = R"({
  "name": "tangled",
  "time": {"step": 0.005, "frame_rate": 50, "frames": 20},
  "materials": {"cotton": {"density": 0.15, "stretch_stiffness": 800, "bending_stiffness": 1e-5,
                           "damping": {"stiffness": 5e-4}}},
  "cloths": [
    {"name": "lower", "grid": {"size": [0.5, 0.5], "cells": [14, 14]}, "material": "cotton",
     "transform": {"translate": [0.01, 0, 0.1]}},
    {"name": "upper", "grid": {"size": [0.4, 0.4], "cells": [11, 11]}, "material": "cotton",
     "transform": {"translate": [0, 0.02, 0.2], "rotate": [30, 0.2, 1, 0]}}],
  "obstacles": [{"name": "ball", "sphere": {"radius": 0.15, "subdivisions": 2}}],
  "contact": {"untangle": true},
  "output": {"checkpoint_every": 5}
})";

class UntangleRun : public Process {
 protected:
  void SetUp() override {
    Process::SetUp();
    write("small.json", tangled_scene);  // what run() runs
  }
};

TEST_F(UntangleRun, RunsCleanFromTheFirstFrame) {
  ASSERT_EQ(run("a"), 0) << err_;
  EXPECT_EQ(weft({"check", "a"}), 0) << out_ << err_;
  EXPECT_NE(out_.find("21 frames checked: 21 clean"), std::string::npos) << out_;
  EXPECT_EQ(Json::parse(text_of(at("a/scene.json")))["contact"]["untangle"], true);
}

TEST_F(UntangleRun, IsRefusedWithoutTheFlag) {
  EXPECT_EQ(run("a", {"--set", "contact.untangle=false"}), 2);
  EXPECT_NE(err_.find("intersect"), std::string::npos) << err_;
  EXPECT_EQ(err_.find("untangling"), std::string::npos) << err_;
  EXPECT_EQ(line_count(err_), 1) << err_;
}

TEST_F(UntangleRun, SameBitsOnTwoRanksAndResumed) {
  ASSERT_EQ(run("a", {"--frames", "8"}), 0) << err_;
  ASSERT_EQ(run("b", {"--frames", "8", "--device", "cpu:2"}), 0) << err_;
  EXPECT_EQ(hash("a"), hash("b"));
  ASSERT_EQ(run("c", {"--frames", "5"}), 0) << err_;
  ASSERT_EQ(run("c", {"--frames", "8", "--resume", "latest"}), 0) << err_;
  EXPECT_EQ(hash("a"), hash("c"));
}

TEST_F(UntangleRun, WhatCannotBePartedIsBadInput) {
  Json scene = Json::parse(tangled_scene);
  scene["pins"] = Json::array({{{"cloth", "lower"}, {"vertices", {7 * 15 + 7}}}});  // in the ball
  write("small.json", scene.dump());
  EXPECT_EQ(run("a"), 2);
  EXPECT_EQ(line_count(err_), 1) << err_;
  EXPECT_NE(err_.find("after untangling, which leaves"), std::string::npos) << err_;
  EXPECT_NE(err_.find(" m between lower and ball at ("), std::string::npos) << err_;
  EXPECT_NE(err_.find("; picture a/failure.png"), std::string::npos) << err_;
  EXPECT_EQ(text_of(at("a/failure.png")).substr(1, 3), "PNG");
  // The picture is no run: the next one needs no --overwrite, and removes it.
  const std::vector<std::string> plain = {"run",          "small.json", "-o", "a",
                                          "--no-preview", "--frames",   "1"};
  write("small.json", tangled_scene);
  EXPECT_EQ(weft(plain), 0) << err_;
  EXPECT_FALSE(fs::exists(at("a/failure.png")));
  // Nothing is drawn into a run that may not be replaced.
  write("small.json", scene.dump());
  EXPECT_EQ(weft(plain), 2);
  EXPECT_EQ(err_.find("; picture"), std::string::npos) << err_;
  EXPECT_FALSE(fs::exists(at("a/failure.png")));
}

}  // namespace
}  // namespace weft::test
