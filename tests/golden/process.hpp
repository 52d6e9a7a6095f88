#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "host/base/scratch_folder.hpp"

/// Tests that run the program as a user does.
namespace weft::test {

namespace fs = std::filesystem;
using Json = nlohmann::json;

/// 288 triangles that fall onto a sphere; 6 frames of 8 steps, a checkpoint every 2 frames.
inline const std::string small_scene = R"({
  "name": "small",
  "device": "cpu",
  "time": {"step": 0.005, "frame_rate": 25, "frames": 6},
  "materials": {"cotton": {"density": 0.15, "stretch_stiffness": 800, "bending_stiffness": 1e-5,
                           "damping": {"stiffness": 5e-4}}},
  "cloths": [
    {"name": "lower", "grid": {"size": [0.5, 0.5], "cells": [12, 12]}, "material": "cotton",
     "transform": {"translate": [0, 0, 0.155]}},
    {"name": "upper", "grid": {"size": [0.3, 0.3], "cells": [6, 6]}, "material": "cotton",
     "transform": {"translate": [0, 0, 0.165], "rotate": [20, 0, 0, 1]}}],
  "obstacles": [{"name": "ball", "sphere": {"radius": 0.15, "subdivisions": 2}}],
  "output": {"checkpoint_every": 2}
})";

/// A sheet between two boxes that close on it; `apart` stands aside. Cloth displaces the boxes from
/// frame 6 of 7 on.
inline const std::string press_scene = R"({
  "name": "press", "device": "cpu",
  "time": {"step": 0.01, "frame_rate": 25, "frames": 7},
  "materials": {"cotton": {"density": 0.15}},
  "contact": {"thickness": 0.004, "compliance_distance": null},
  "cloths": [{"name": "sheet", "material": "cotton",
              "grid": {"size": [0.3, 0.3], "cells": [8, 8]}}],
  "obstacles": [
    {"name": "apart", "box": {"size": [0.1, 0.1, 0.1], "cells": [1, 1, 1]}, "transform": {"translate": [1, 0, 0]}},
    {"name": "below", "box": {"size": [0.2, 0.2, 0.1], "cells": [4, 4, 2]}, "motion": [
      {"time": 0, "translate": [0, 0, -0.07]}, {"time": 0.4, "translate": [0, 0, -0.035]}]},
    {"name": "above", "box": {"size": [0.2, 0.2, 0.1], "cells": [4, 4, 2]}, "motion": [
      {"time": 0, "translate": [0, 0, 0.07]}, {"time": 0.4, "translate": [0, 0, 0.035]}]}],
  "output": {"checkpoint_every": 6}
})";

inline std::string text_of(const fs::path& path) {
  std::stringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

inline std::ptrdiff_t line_count(const std::string& text) {
  return std::count(text.begin(), text.end(), '\n');
}

/// A directory of its own for each test, and the program run in it.
class Process : public testing::Test {
 protected:
  void SetUp() override { write("small.json", small_scene); }
  void TearDown() override {
    if (!HasFailure()) return;
    folder_.keep();
    std::cout << "the test's directory: " << directory_ << "\n";
  }

  fs::path at(const std::string& name) const { return directory_ / name; }

  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(at(name), std::ios::binary) << text;
    return at(name).string();
  }

  /// Starts the program in the test's directory.
  pid_t start(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), WEFT_PROGRAM);
    return start_words(std::move(arguments));
  }
  /// Starts any program in the same way.
  pid_t start_words(std::vector<std::string> words) const {
    std::vector<char*> argv;
    for (auto& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    const pid_t child = ::fork();
    if (child != 0) return child;
    const int out = ::open(at("stdout").c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
    const int err = ::open(at("stderr").c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
    if (::chdir(directory_.c_str()) != 0 || ::dup2(out, 1) < 0 || ::dup2(err, 2) < 0) ::_exit(126);
    ::execv(argv[0], argv.data());
    ::_exit(127);
  }

  /// @return the exit code, or minus the signal that ended it
  int wait(pid_t child) {
    int status = 0;
    ::waitpid(child, &status, 0);
    out_ = text_of(at("stdout"));
    err_ = text_of(at("stderr"));
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }

  static bool runs(pid_t child) {
    siginfo_t ended{};
    return ::waitid(P_PID, static_cast<id_t>(child), &ended, WEXITED | WNOHANG | WNOWAIT) == 0 &&
           ended.si_pid == 0;
  }

  int weft(const std::vector<std::string>& arguments) { return wait(start(arguments)); }

  /// Runs `weft` and sends it a signal once a file is there; again without `output` if it was done
  /// before the signal came, as it may be where the machine is busy.
  /// @return as wait()
  int stopped(const std::vector<std::string>& arguments, const fs::path& output,
              const fs::path& file, int signal) {
    int code = 0;
    for (int attempt = 0; attempt < 10 && code == 0; ++attempt) {
      fs::remove_all(output);
      const pid_t child = start(arguments);
      while (!fs::exists(file) && runs(child))
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      ::kill(child, signal);
      code = wait(child);
    }
    return code;
  }

  /// `weft run small.json -o DIR --no-preview ...`, which replaces a run that is there unless it
  /// resumes one
  static std::vector<std::string> run_arguments(const std::string& output,
                                                const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments{"run", "small.json", "-o", output, "--no-preview"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    if (std::find(more.begin(), more.end(), "--resume") == more.end())
      arguments.emplace_back("--overwrite");
    return arguments;
  }
  int run(const std::string& output, const std::vector<std::string>& more = {}) {
    return weft(run_arguments(output, more));
  }

  Json report(const std::string& output) const {
    return Json::parse(text_of(at(output) / "report.json"));
  }
  std::string hash(const std::string& output) const { return report(output).at("state_hash"); }

  ScratchFolder folder_;
  const fs::path directory_ = folder_.path();
  std::string out_;
  std::string err_;
};

}  // namespace weft::test
