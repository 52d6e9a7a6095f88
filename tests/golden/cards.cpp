// The scene `gpus`: whatever contact does, it must not make a stack at rest move.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "tests/golden/process.hpp"

namespace weft::test {
namespace {

constexpr double card_length = 0.09;  ///< [m]
constexpr double drift_max = 1e-8 * card_length;

std::vector<std::array<double, 3>> vertices(const fs::path& obj) {
  std::vector<std::array<double, 3>> found;
  std::istringstream lines(text_of(obj));
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("v ", 0) != 0) continue;
    std::istringstream numbers(line.substr(2));
    std::array<double, 3> x{};
    numbers >> x[0] >> x[1] >> x[2];
    found.push_back(x);
  }
  return found;
}

class Cards : public Process {
 protected:
  /// Runs the scene and holds every frame against the first.
  void expect_no_drift(int frames) {
    ASSERT_EQ(weft({"run", (fs::path(WEFT_SOURCE_DIR) / "scenes/cards.json").string(), "-o", "a",
                    "--no-preview", "--frames", std::to_string(frames)}),
              0)
        << err_;
    const auto start = vertices(at("a/frames/cloth_00000.obj"));
    ASSERT_GT(start.size(), 100u);
    for (int n = 1; n <= frames; ++n) {
      char name[48];
      std::snprintf(name, sizeof name, "a/frames/cloth_%05d.obj", n);
      const auto now = vertices(at(name));
      ASSERT_EQ(now.size(), start.size()) << name;
      double drift = 0;
      for (std::size_t v = 0; v < now.size(); ++v)
        for (std::size_t c = 0; c < 3; ++c)
          drift = std::max(drift, std::abs(now[v][c] - start[v][c]));
      EXPECT_LT(drift, drift_max) << name;
    }
    // They do press on each other, all the time.
    std::istringstream steps(text_of(at("a/steps.jsonl")));
    int count = 0;
    for (std::string line; std::getline(steps, line); ++count) {
      const Json step = Json::parse(line);
      EXPECT_GT(step["proximities"], 500) << "step " << count;
      EXPECT_EQ(step["impacts"], 0) << "step " << count;
    }
    EXPECT_EQ(count, 200 * frames);
  }
};

TEST_F(Cards, NothingDriftsIn400Steps) {
  expect_no_drift(2);
}

class SlowGpus : public Cards {};

TEST_F(SlowGpus, NothingDriftsIn10000Steps) {
  expect_no_drift(50);
}

}  // namespace
}  // namespace weft::test
