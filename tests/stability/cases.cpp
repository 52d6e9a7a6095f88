// What simulations fail at, each case once a method: right, or refused by name. What is known to
// fail (benchmarks/stability/known_failures.cpp) has to fail.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <ostream>
#include <string>
#include <string_view>
#include <vector>

#include "benchmarks/stability/case.hpp"
#include "benchmarks/stability/isolate.hpp"

namespace weft::stability {
namespace {

struct Run {
  std::string name;
  std::string method;
};

void PrintTo(const Run& run, std::ostream* out) {
  *out << run.name << ' ' << run.method;
}

std::string name_of(const ::testing::TestParamInfo<Run>& info) {
  std::string name = info.param.name + "_" + info.param.method;
  std::replace(name.begin(), name.end(), '+', '0');
  return name;
}

/// Cases that take longer than a few seconds with a method.
constexpr std::array<std::array<std::string_view, 2>, 39> slow{{
    {"rest_plate", "adaptive"},
    {"rest_hinge", "adaptive"},
    {"rest_hinge", "asynchronous"},
    {"gravity_1e6", "implicit"},
    {"gravity_1e6", "adaptive"},
    {"storm", "implicit"},
    {"storm", "adaptive"},
    {"mass_ratio_1", "asynchronous"},
    {"mass_ratio_100", "asynchronous"},
    {"fold_200", "implicit"},
    {"fold_200", "adaptive"},
    {"saddle_newton", "adaptive"},
    {"rest_plate", "view"},
    {"rest_hinge", "view"},
    {"gravity_1e6", "view"},
    {"storm", "view"},
    {"fold_200", "view"},
    {"saddle_newton", "view"},
    {"compressed", "view"},
    {"saddle_newton", "time_parallel"},
    {"fold_200", "time_parallel"},
    {"fold_200_through", "time_parallel"},
    {"fold_200_through_hinge", "time_parallel"},
    {"mass_ratio_100", "time_parallel"},
    {"bow_tie", "time_parallel"},
    {"pressure_1e6", "implicit"},
    {"pressure_1e6", "adaptive"},
    {"pressure_1e6", "view"},
    {"pressure_1e6", "time_parallel"},
    {"storm", "time_parallel"},
    {"rest_plate", "time_parallel"},
    {"rest_hinge", "time_parallel"},
    {"time_step_1_1000", "time_parallel"},
    {"gravity_1e6", "time_parallel"},
    {"compressed", "time_parallel"},
    {"out_of_memory", "time_parallel"},
    {"scaled_1024", "time_parallel"},
    {"scaled_1_1024", "time_parallel"},
    {"far_away", "time_parallel"},
}};

bool is_slow(const Run& run) {
  return takes_long(run.name, run.method) ||
         std::any_of(slow.begin(), slow.end(),
                     [&](const auto& s) { return s[0] == run.name && s[1] == run.method; });
}

std::vector<Run> runs(bool slow_ones) {
  std::vector<Run> all;
  for (const Case& c : all_cases())
    for (const std::string& method : methods())
      if (const Run run{c.name, method}; is_slow(run) == slow_ones) all.push_back(run);
  return all;
}

void check(const Run& run) {
  const Case& c = find_case(run.name);
  const bool takes_longer = takes_long(run.name, run.method);
  const Verdict verdict = run_apart(c, {run.method, 1, "cpu:1"}, takes_longer ? 60 : 240);
  ::testing::Test::RecordProperty("outcome", describe(verdict.outcome));
  ::testing::Test::RecordProperty("detail", verdict.detail);
  if (takes_longer && verdict.detail.starts_with("not done after"))
    GTEST_SKIP() << "known to take long: " << verdict.detail;
  if (const char* reason = known_failure(run.name, run.method))
    EXPECT_EQ(verdict.outcome, Outcome::failed)
        << "does not fail now: take it out of known_failures.cpp; it says: " << reason;
  else
    EXPECT_NE(verdict.outcome, Outcome::failed) << verdict.detail;
}

class StabilityTest : public ::testing::TestWithParam<Run> {};
class SlowStabilityTest : public ::testing::TestWithParam<Run> {};

TEST_P(StabilityTest, EndsRightOrIsRefused) {
  check(GetParam());
}

TEST_P(SlowStabilityTest, EndsRightOrIsRefused) {
  check(GetParam());
}

INSTANTIATE_TEST_SUITE_P(Case, StabilityTest, ::testing::ValuesIn(runs(false)), name_of);
INSTANTIATE_TEST_SUITE_P(Case, SlowStabilityTest, ::testing::ValuesIn(runs(true)), name_of);

}  // namespace
}  // namespace weft::stability
