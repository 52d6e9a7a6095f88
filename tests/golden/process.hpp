#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

/// Tests that run the program as a user does.
namespace weft::test {

namespace fs = std::filesystem;
using Json = nlohmann::json;

/// 288 triangles that fall onto a sphere; 6 frames of 8 steps, a checkpoint every 2 frames.
inline const std::string small_scene = R"({
  "name": "small",
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
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    std::string name = std::string(test->test_suite_name()) + "_" + test->name();
    std::replace(name.begin(), name.end(), '/', '_');
    directory_ = fs::path(testing::TempDir()) / ("weft_run_" + name);
    fs::remove_all(directory_);
    fs::create_directories(directory_);
    write("small.json", small_scene);
  }
  void TearDown() override {
    if (!HasFailure()) fs::remove_all(directory_);
  }

  fs::path at(const std::string& name) const { return directory_ / name; }

  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(at(name), std::ios::binary) << text;
    return at(name).string();
  }

  /// Starts the program in the test's directory.
  pid_t start(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), WEFT_PROGRAM);
    std::vector<char*> argv;
    for (auto& argument : arguments) argv.push_back(argument.data());
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

  int weft(const std::vector<std::string>& arguments) { return wait(start(arguments)); }

  /// `weft run small.json -o DIR --no-preview ...`
  static std::vector<std::string> run_arguments(const std::string& output,
                                                const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments{"run", "small.json", "-o", output, "--no-preview"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  int run(const std::string& output, const std::vector<std::string>& more = {}) {
    return weft(run_arguments(output, more));
  }

  Json report(const std::string& output) const {
    return Json::parse(text_of(at(output) / "report.json"));
  }
  std::string hash(const std::string& output) const { return report(output).at("state_hash"); }

  fs::path directory_;
  std::string out_;
  std::string err_;
};

}  // namespace weft::test
