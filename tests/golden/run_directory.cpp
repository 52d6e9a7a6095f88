// A run directory is precious: one run at a time, nothing replaced unasked, nothing resumed that is
// not the same scene, and an end at the next safe point when a signal asks for it.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <array>
#include <chrono>
#include <filesystem>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "tests/golden/process.hpp"

namespace weft::test {
namespace {

using Clock = std::chrono::steady_clock;

class RunDirectoryTest : public Process {
 protected:
  /// A run of some seconds into "a", once it has a checkpoint.
  pid_t start_long_run() {
    const pid_t child =
        start(run_arguments("a", {"--frames", "4000", "--set", "output.checkpoint_every=1"}));
    while (!fs::exists(at("a/checkpoint_00001.weft")) && runs(child))
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return child;
  }
  /// Whether the run ends within so many seconds; if not it is killed.
  bool ends_within(pid_t child, double seconds) {
    const auto begin = Clock::now();
    while (runs(child)) {
      if (std::chrono::duration<double>(Clock::now() - begin).count() > seconds) {
        ::kill(child, SIGKILL);
        return false;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return true;
  }
};

// ------------------------------------------------------------------------------------ one at a
// time

TEST_F(RunDirectoryTest, ASecondRunIsRefusedByName) {
  const pid_t first = start_long_run();
  for (const auto& more : {std::vector<std::string>{}, {"--overwrite"}, {"--resume", "latest"}}) {
    std::vector<std::string> arguments{"run", "small.json", "-o", "a", "--no-preview"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    EXPECT_EQ(weft(arguments), 2) << err_;
    EXPECT_EQ(line_count(err_), 1) << err_;
    EXPECT_EQ(err_.find("weft: a: -o: a directory that "), 0u) << err_;
    if (more.empty()) continue;  // the run that it holds is reason enough
    EXPECT_NE(err_.find("process " + std::to_string(first) + ";"), std::string::npos) << err_;
  }
  ::kill(first, SIGTERM);
  EXPECT_EQ(wait(first), 130) << err_;
  EXPECT_EQ(line_count(text_of(at("a/steps.jsonl"))), report("a")["steps"]);
  // The lock has gone with its process.
  EXPECT_EQ(run("a", {"--frames", "1"}), 0) << err_;
}

TEST_F(RunDirectoryTest, TheLockDiesWithItsProcess) {
  const pid_t first = start_long_run();
  ::kill(first, SIGKILL);
  EXPECT_EQ(wait(first), -SIGKILL);
  EXPECT_EQ(
      weft({"run", "small.json", "-o", "a", "--no-preview", "--resume", "latest", "--frames", "8"}),
      0)
      << err_;
}

TEST_F(RunDirectoryTest, AForeignLockFileIsNoLock) {
  fs::create_directories(at("a"));
  fs::create_symlink(at("elsewhere"), at("a/.weft.lock"));
  EXPECT_EQ(run("a"), 2) << err_;
  EXPECT_NE(err_.find("a/.weft.lock: cannot lock"), std::string::npos) << err_;
  EXPECT_FALSE(fs::exists(at("elsewhere")));
}

// ------------------------------------------------------------------------------ nothing is
// replaced

TEST_F(RunDirectoryTest, ARunIsReplacedOnlyIfAsked) {
  ASSERT_EQ(weft({"run", "small.json", "-o", "a", "--no-preview"}), 0) << err_;
  const std::string before = text_of(at("a/report.json"));
  const std::vector<std::vector<std::string>> commands{
      {"run", "small.json", "-o", "a", "--frames", "2"},
      {"run", "small.json", "-o", "a", "--frames", "2", "--set", "method.type=time_parallel"},
      {"run", "small.json", "-o", "a", "--frames", "2", "--need", "intersections=0"},
  };
  for (const auto& command : commands) {
    EXPECT_EQ(weft(command), 2) << testing::PrintToString(command) << out_;
    EXPECT_EQ(err_,
              "weft: a: -o: a directory that holds another run; allowed: another "
              "directory, --resume latest to continue that run, or --overwrite to replace it\n")
        << testing::PrintToString(command);
    EXPECT_EQ(text_of(at("a/report.json")), before);
  }
  for (auto command : commands) {
    command.insert(command.end(), {"--overwrite", "--no-preview"});
    EXPECT_EQ(weft(command), 0) << testing::PrintToString(command) << err_;
    EXPECT_EQ(report("a")["frames"], 2);
    EXPECT_FALSE(fs::exists(at("a/frames/cloth_00003.obj")));
  }
}

/// Neither message sends to the other.
TEST_F(RunDirectoryTest, ARunWithoutACheckpointIsReplaced) {
  ASSERT_EQ(run("a", {"--frames", "1"}), 0) << err_;
  fs::remove(at("a/checkpoint_00001.weft"));
  fs::remove(at("a/report.json"));
  EXPECT_EQ(weft({"check", "a"}), 0) << err_;
  EXPECT_EQ(err_, "weft: warning: a: the run has no report.json, so it goes on or was killed\n");
  std::vector<std::string> command{"run", "small.json", "-o", "a", "--no-preview"};
  EXPECT_EQ(weft(command), 2);
  EXPECT_EQ(err_,
            "weft: a: -o: a directory that holds another run; allowed: another directory, or "
            "--overwrite to replace it\n");
  command.insert(command.end(), {"--resume", "latest"});
  EXPECT_EQ(weft(command), 2);
  EXPECT_EQ(err_,
            "weft: a: --resume: latest; allowed: a directory with a checkpoint; it has none, so "
            "run with --overwrite instead of --resume\n");
}

TEST_F(RunDirectoryTest, ChecksSayThatARunEndedEarly) {
  EXPECT_EQ(weft({"run", "small.json", "-o", "a", "--no-preview", "--frames", "100000",
                  "--time-limit", "1"}),
            130)
      << err_;
  EXPECT_EQ(weft({"check", "a"}), 0) << err_;
  EXPECT_EQ(err_, "weft: warning: a: the run is not whole: stopped by the time limit of 1 s\n");
  EXPECT_EQ(weft({"check", "a", "--quiet"}), 0);
  EXPECT_EQ(err_, "");
}

TEST_F(RunDirectoryTest, AFileBeyondTheLimitOfTheShellIsNamed) {
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  rlimit small = before;
  small.rlim_cur = 20000;
  ::setrlimit(RLIMIT_FSIZE, &small);
  const int code = run("a", {"--set", "cloths.0.grid.cells=[40,40]"});
  ::setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_EQ(code, 2) << err_;
  EXPECT_EQ(line_count(err_), 1) << err_;
  EXPECT_NE(err_.find("cannot write: File too large"), std::string::npos) << err_;
}

TEST_F(RunDirectoryTest, ACheckpointFromElsewhereReplacesNothing) {
  ASSERT_EQ(run("a", {"--frames", "2"}), 0) << err_;
  ASSERT_EQ(run("b", {"--frames", "2"}), 0) << err_;
  std::vector<std::string> command{
      "run", "small.json", "-o", "b", "--no-preview", "--resume", "a/checkpoint_00002.weft"};
  EXPECT_EQ(weft(command), 2) << out_;
  EXPECT_NE(err_.find("--overwrite"), std::string::npos) << err_;
  command.emplace_back("--overwrite");
  EXPECT_EQ(weft(command), 0) << err_;
}

// ------------------------------------------------------------------------------------ the same
// scene

const std::string pinned_scene = R"({
  "name": "pinned", "device": "cpu",
  "time": {"step": 0.01, "frame_rate": 25, "frames": 2},
  "materials": {"cotton": {"density": 0.15}},
  "cloths": [{"name": "sheet", "material": "cotton", "grid": {"size": [1, 1], "cells": [4, 4]}}],
  "obstacles": [{"name": "ball", "sphere": {"radius": 0.1, "subdivisions": 1}, "motion": [
    {"time": 0, "translate": [0, 0, -2]},
    {"time": 1, "translate": [0, 0, -3]}]}],
  "pins": [{"cloth": "sheet", "corners": ["min_min", "min_max"]}],
  "wind": {"density": 1.2, "velocity": [1, 0, 0]},
  "output": {"checkpoint_every": 1}
})";

TEST_F(RunDirectoryTest, ACheckpointOfAChangedSceneIsRefusedByName) {
  write("pinned.json", pinned_scene);
  ASSERT_EQ(weft({"run", "pinned.json", "-o", "a", "--no-preview"}), 0) << err_;
  const std::vector<std::array<std::string, 2>> changes{
      {"pins.0.corners=[\"min_min\",\"max_max\"]", "pins[0].vertices was [0, 20], now [0, 24]"},
      {"pins.0.release_time=3", "pins[0].release_time was inf, now 3"},
      {"materials.cotton.density=0.2", "materials.cotton.density was 0.15, now 0.2"},
      {"wind.velocity=[2,0,0]", "wind.velocity was [1, 0, 0], now [2, 0, 0]"},
      {"gravity=[0,0,-9]", "gravity was [0, 0, -9.81], now [0, 0, -9]"},
      {"time.step=0.005", "time.step was 0.01, now 0.005"},
      {"time.frame_rate=50", "time.frame_rate was 25, now 50"},
      {"obstacles.0.motion.1.time=2", "obstacles.ball.motion was [0: translate"},
      {"contact.friction=0.1", "contact.friction was 0.3, now 0.1"},
      {"solver.tolerance=0.001", "solver.tolerance was 0.01, now 0.001"},
      {"cloths.0.transform.translate=[0,0,1]", "cloths.sheet.mesh has changed"},
  };
  for (const auto& [change, name] : changes) {
    const std::vector<std::string> command{
        "run",      "pinned.json", "-o",           "b",     "--resume", "a/checkpoint_00002.weft",
        "--frames", "4",           "--no-preview", "--set", change};
    EXPECT_EQ(weft(command), 2) << change << out_;
    EXPECT_EQ(line_count(err_), 1) << err_;
    EXPECT_NE(err_.find(name), std::string::npos) << change << ": " << err_;
    EXPECT_NE(err_.find("--resume-changed"), std::string::npos) << err_;
    EXPECT_FALSE(fs::exists(at("b")));
  }
  for (const auto& [change, name] : changes) {
    const std::vector<std::string> command{"run",          "pinned.json",
                                           "-o",           "b",
                                           "--resume",     "a/checkpoint_00002.weft",
                                           "--frames",     "5",
                                           "--no-preview", "--resume-changed",
                                           "--overwrite",  "--set",
                                           change};
    EXPECT_EQ(weft(command), 0) << change << err_;
    EXPECT_NE(err_.find("weft: warning: "), std::string::npos) << err_;
    EXPECT_NE(err_.find(name), std::string::npos) << change << ": " << err_;
    EXPECT_NEAR(report("b")["simulated_s"].get<double>(),
                change.starts_with("time.frame_rate") ? 0.1 : 0.2, 1e-9)
        << change;
  }
}

TEST_F(RunDirectoryTest, OutputDeviceAndDurationMayChange) {
  ASSERT_EQ(run("a", {"--frames", "2"}), 0) << err_;
  EXPECT_EQ(weft({"run", "small.json", "-o", "a", "--no-preview", "--resume", "latest", "--frames",
                  "3", "--device", "cpu:2", "--set", "output.checkpoint_every=1"}),
            0)
      << err_;
  EXPECT_EQ(err_, "");
}

TEST_F(RunDirectoryTest, SceneOfThatNameIsNotReplaced) {
  fs::rename(at("small.json"), at("scene.json"));
  fs::create_directory(at("a"));
  const std::string before = text_of(at("scene.json"));
  for (const fs::path& output : {fs::path("."), fs::path("a/.."), directory_}) {
    EXPECT_EQ(weft({"run", "scene.json", "-o", output, "--overwrite", "--frames", "1"}), 2) << out_;
    EXPECT_NE(err_.find(": -o: the folder of the scene"), std::string::npos) << err_;
  }
  EXPECT_EQ(text_of(at("scene.json")), before);
  ASSERT_EQ(weft({"run", "scene.json", "-o", "a", "--frames", "1", "--no-preview"}), 0) << err_;
  EXPECT_EQ(weft({"run", "a/scene.json", "-o", "a", "--overwrite", "--no-preview"}), 0) << err_;
}

TEST_F(RunDirectoryTest, FewerFramesThanTheCheckpointHasAreRefused) {
  ASSERT_EQ(run("a", {"--frames", "2"}), 0) << err_;
  const std::string before = text_of(at("a/report.json"));
  EXPECT_EQ(run("a", {"--resume", "latest", "--frames", "1"}), 2) << out_;
  EXPECT_EQ(
      err_,
      "weft: --frames: 1; allowed: at least 2, as many frames as a/checkpoint_00002.weft has\n");
  EXPECT_EQ(text_of(at("a/report.json")), before);
  EXPECT_EQ(run("a", {"--resume", "latest", "--frames", "2"}), 0)
      << "nothing is left to do: " << err_;
}

TEST_F(RunDirectoryTest, OtherStepsNeedAnotherDirectory) {
  ASSERT_EQ(run("a", {"--frames", "2"}), 0) << err_;
  const std::string before = text_of(at("a/steps.jsonl"));
  EXPECT_EQ(weft({"run", "small.json", "-o", "a", "--no-preview", "--resume", "latest",
                  "--resume-changed", "--set", "time.step=0.01"}),
            2)
      << out_;
  EXPECT_EQ(line_count(err_), 1) << err_;
  EXPECT_EQ(err_.find("although"), std::string::npos) << "it was not resumed: " << err_;
  EXPECT_EQ(text_of(at("a/steps.jsonl")), before);
  // 0.08 s is no end of a frame of 1/30 s.
  EXPECT_EQ(
      weft({"run", "small.json", "-o", "b", "--no-preview", "--resume", "a/checkpoint_00002.weft",
            "--resume-changed", "--set", "time.frame_rate=30", "--set", "time.step=0.011"}),
      2)
      << out_;
  EXPECT_NE(err_.find("checkpoint time"), std::string::npos) << err_;
}

TEST_F(RunDirectoryTest, SlicesOfAChangedSceneAreRefusedByName) {
  const std::vector<std::string> arguments{"run",
                                           "small.json",
                                           "-o",
                                           "a",
                                           "--no-preview",
                                           "--method",
                                           "time_parallel",
                                           "--set",
                                           "method.time_parallel.slices=2"};
  ASSERT_EQ(weft(arguments), 0) << err_;
  EXPECT_NE(out_.find("frames of all slices  7/7"), std::string::npos) << "no progress: " << out_;
  auto changed = arguments;
  changed.insert(changed.end(), {"--resume", "latest", "--set", "gravity=[0,0,-9]"});
  EXPECT_EQ(weft(changed), 2) << out_;
  EXPECT_EQ(line_count(err_), 1) << err_;
  EXPECT_NE(err_.find("gravity"), std::string::npos) << err_;
}

// --------------------------------------------------------------------------------------- signals

TEST_F(RunDirectoryTest, SignalsEndALongStep) {
  ASSERT_EQ(run("start", {"--frames", "2"}), 0) << err_;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    fs::remove_all(at("a"));
    // Newton's method goes on for minutes: it never gets that far.
    const pid_t child =
        start(run_arguments("a", {"--resume", "start/checkpoint_00002.weft", "--resume-changed",
                                  "--set", "solver.newton_iterations=100000", "--experimental",
                                  "solver.newton_tolerance=1e-15"}));
    while (!fs::exists(at("a/frames/cloth_00002.obj")) && runs(child))
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    ASSERT_TRUE(runs(child)) << "the step is not long enough";
    ::kill(child, signal);
    ASSERT_TRUE(ends_within(child, 2)) << "signal " << signal;
    ASSERT_EQ(wait(child), 130) << signal << err_;
    EXPECT_NE(err_.find("weft: stopped by a signal; checkpoint a/checkpoint_00002.weft\n"),
              std::string::npos)
        << err_;
    EXPECT_EQ(report("a")["failure"], "stopped by a signal");
    // The step that was under way has left nothing behind.
    EXPECT_EQ(report("a")["steps"], 16);
    EXPECT_EQ(hash("a"), hash("start"));
    EXPECT_EQ(line_count(text_of(at("a/steps.jsonl"))), 16);
    EXPECT_FALSE(fs::exists(at("a/frames/cloth_00003.obj")));
  }
  // And what it has left can be resumed, to the bit.
  ASSERT_EQ(run("whole", {"--frames", "4"}), 0) << err_;
  ASSERT_EQ(run("b", {"--resume", "a/checkpoint_00002.weft", "--resume-changed", "--frames", "4"}),
            0)
      << err_;
  EXPECT_EQ(hash("b"), hash("whole"));
}

TEST_F(RunDirectoryTest, ALongStepSaysHowFarItIs) {
  // As above, Newton's method goes on for minutes.
  const pid_t child =
      start(run_arguments("a", {"--set", "solver.newton_iterations=100000", "--experimental",
                                "solver.newton_tolerance=1e-15"}));
  const std::string begin = "step 1  1 s  solve  ";
  for (int n = 0; n < 1000 && runs(child); ++n) {
    if (text_of(at("stdout")).find(begin) != std::string::npos) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  ASSERT_TRUE(runs(child)) << "the step is not long enough";
  ::kill(child, SIGTERM);
  EXPECT_EQ(wait(child), 130) << err_;
  EXPECT_NE(out_.find(begin), std::string::npos) << out_;
  EXPECT_EQ(out_.find("  0 solves"), std::string::npos) << out_;
}

TEST_F(RunDirectoryTest, ASecondSignalASecondLaterEndsAtOnce) {
  const pid_t child = start_long_run();
  ::kill(child, SIGINT);
  ::kill(child, SIGSTOP);  // perhaps before the first one can be acted upon
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));
  ::kill(child, SIGTERM);
  ::kill(child, SIGCONT);
  const int code = wait(child);
  EXPECT_TRUE(code == -SIGTERM || code == 130) << code;
}

/// As from `timeout`, which signals the program and its group.
TEST_F(RunDirectoryTest, SignalsAtOnceAreOne) {
  const pid_t child = start_long_run();
  ::kill(child, SIGSTOP);
  ::kill(child, SIGTERM);
  ::kill(child, SIGINT);
  ::kill(child, SIGCONT);
  EXPECT_EQ(wait(child), 130) << err_;
  EXPECT_TRUE(fs::exists(at("a/report.json")));
}

TEST_F(RunDirectoryTest, ABrokenPipeEndsTheRunWithACheckpoint) {
  const std::string command = std::string(WEFT_PROGRAM) +
                              " run small.json -o a --no-preview --frames 4000 | head -n 2 "
                              ">/dev/null; exit ${PIPESTATUS[0]}";
  EXPECT_EQ(wait(start_words({"/bin/bash", "-c", command})), 130) << err_;
  EXPECT_EQ(report("a")["failure"], "stopped by a signal");
  EXPECT_LT(report("a")["frames"], 4000);
  EXPECT_EQ(line_count(text_of(at("a/steps.jsonl"))), report("a")["steps"]);
}

// -------------------------------------------------------------------------------------- and the
// rest

TEST_F(RunDirectoryTest, PipesAreNeverWaitedFor) {
  ASSERT_EQ(run("a", {"--frames", "4"}), 0) << err_;
  ASSERT_EQ(::mkfifo(at("a/checkpoint_00099.weft").c_str(), 0666), 0);
  fs::remove(at("a/report.json"));
  ASSERT_EQ(::mkfifo(at("a/report.json").c_str(), 0666), 0);
  fs::remove(at("a/scene.json"));
  ASSERT_EQ(::mkfifo(at("a/scene.json").c_str(), 0666), 0);
  const pid_t child = start(run_arguments("a", {"--resume", "latest", "--device", "cpu"}));
  ASSERT_TRUE(ends_within(child, 20));
  EXPECT_EQ(wait(child), 2) << out_ << err_;
  EXPECT_EQ(line_count(err_), 1) << err_;
  EXPECT_NE(err_.find("a/scene.json"), std::string::npos) << err_;
  ASSERT_EQ(::mkfifo(at("pipe").c_str(), 0666), 0);
  const pid_t other = start(run_arguments("b", {"--resume", "pipe"}));
  ASSERT_TRUE(ends_within(other, 20));
  EXPECT_EQ(wait(other), 2);
  EXPECT_EQ(err_, "weft: pipe: cannot read: not a regular file\n");
}

TEST_F(RunDirectoryTest, AFailedStepLeavesNoFrame) {
  // Free fall converges at once; the solver cannot once the sheet touches the ball.
  EXPECT_EQ(
      run("a", {"--experimental", "solver.max_iterations=1", "--set", "solver.tolerance=1e-6"}), 4)
      << out_ << err_;
  const auto steps = report("a")["steps"].get<int>();
  int frames = -1;
  for (const auto& entry : fs::directory_iterator(at("a/frames")))
    frames += entry.path().filename().string().starts_with("cloth_");
  EXPECT_EQ(frames, steps / 8);
}

TEST_F(RunDirectoryTest, ClothThatMayPassThroughItselfHasNoIntersections) {
  write("crossing.json", R"({"time": {"frames": 1}, "contact": {"self": false}, "cloths": [
    {"grid": {"size": [1, 1], "cells": [4, 4]}},
    {"grid": {"size": [1, 1], "cells": [4, 4]}, "transform": {"rotate": [90, 1, 0, 0]}}]})");
  EXPECT_EQ(weft({"run", "crossing.json", "-o", "a", "--no-preview"}), 0) << err_;
  EXPECT_EQ(report("a")["intersections"], 0);
  EXPECT_EQ(err_.find("intersection"), std::string::npos) << err_;
}

TEST_F(RunDirectoryTest, AReportThatCannotBeWrittenIsRefusedAtOnce) {
  write("file", "");
  for (const char* path : {"none/report.json", "file/report.json", "."}) {
    EXPECT_EQ(run("a", {"--report", path}), 2) << path;
    EXPECT_EQ(err_.find("weft: --report: "), 0u) << err_;
    EXPECT_FALSE(fs::exists(at("a")));
  }
}

}  // namespace
}  // namespace weft::test
