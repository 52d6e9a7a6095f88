// `weft run` with the method asynchronous: where its time went, in report.json and steps.jsonl, and
// how a run ends that its caps stop.
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include "tests/golden/process.hpp"

namespace weft::test {
namespace {

class AsynchronousRun : public Process {
 protected:
  int run(const std::string& output, const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments{"--method", "asynchronous", "--set", "precision=double"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Process::run(output, arguments);
  }
};

/// The five parts of figure 1 of Ainsley et al. 2012 are all of the time, the counts those of the
/// steps.
TEST_F(AsynchronousRun, ReportSaysWhereTheTimeWent) {
  ASSERT_EQ(run("a"), 0) << err_;
  EXPECT_EQ(weft({"check", "a"}), 0) << out_ << err_;
  const Json r = report("a");
  const Json& all = r.at("asynchronous");
  double parts = 0;
  for (const char* part :
       {"useful_ms", "resimulation_ms", "detection_ms", "unneeded_ms", "bookkeeping_ms"}) {
    EXPECT_GT(all.at(part).get<double>(), 0) << part;
    parts += all.at(part).get<double>();
  }
  const double wall = r.at("wall_s").get<double>() * 1e3;
  EXPECT_LE(parts, wall);
  const Json& stages = r.at("stages_ms");
  double staged = 0;
  for (const auto& stage : stages) staged += stage.get<double>();
  EXPECT_NEAR(parts, staged, 1e-6 * staged);
  for (const char* count :
       {"windows", "clean_windows", "rollbacks", "ticks", "elements", "layer_pairs", "acting_pairs",
        "resimulated", "layers_added", "candidates", "slabs"}) {
    std::istringstream lines(text_of(at("a/steps.jsonl")));
    std::int64_t sum = 0;
    for (std::string line; std::getline(lines, line);)
      sum += Json::parse(line).at("asynchronous").at(count).get<std::int64_t>();
    EXPECT_GT(sum, 0) << count;
    EXPECT_EQ(all.at(count), sum) << count;
  }
  EXPECT_EQ(all.at("windows").get<std::int64_t>(), 48 * 2) << "5 ms in windows of at most 3 ms";
  EXPECT_LE(all.at("failsafe"), all.at("candidates"));
}

/// Each cap ends the run with code 4, one line, and a checkpoint that goes on where the cap is
/// gone.
TEST_F(AsynchronousRun, CapsEndItWithACheckpoint) {
  ASSERT_EQ(run("whole"), 0) << err_;
  struct Cap {
    std::string set, message;
  };
  for (const Cap& cap : {Cap{"layers=1",
                             "penalty layer 2 would be needed; "
                             "the last one is layer 1"},
                         Cap{"rollbacks=0", "pairs still come too close after 0 rollbacks"},
                         Cap{"smallest_step=3e-5", "would need a step below 3e-05 s"}}) {
    ASSERT_EQ(run("a", {"--experimental", "method.asynchronous." + cap.set}), 4)
        << cap.set << out_ << err_;
    EXPECT_EQ(line_count(err_), 1) << err_;
    EXPECT_NE(err_.find(cap.message), std::string::npos) << err_;
    EXPECT_NE(err_.find("; checkpoint a/checkpoint_"), std::string::npos) << err_;
    EXPECT_NE(err_.find("; picture a/failure.png"), std::string::npos) << err_;
    EXPECT_TRUE(report("a").contains("failure_place"));
    EXPECT_TRUE(report("a").contains("failure"));
    EXPECT_EQ(weft({"check", "a"}), 0) << out_ << err_;
    ASSERT_EQ(run("a", {"--resume", "latest"}), 0) << cap.set << err_;
    EXPECT_EQ(hash("a"), hash("whole")) << cap.set;
    fs::remove_all(at("a"));
  }
}

TEST_F(AsynchronousRun, SameBitsForAnyNumberOfThreads) {
  std::string first;
  for (const char* device : {"cpu:1", "cpu:2", "cpu:3", "cpu:8"}) {
    ASSERT_EQ(run("a", {"--device", device}), 0) << err_;
    if (first.empty()) first = hash("a");
    EXPECT_EQ(hash("a"), first) << device;
  }
}

/// The paper's trash compactor at its full size: the walls stand still for the last half of a
/// second, and what they hold has come to rest.
TEST_F(Process, SlowTrashCompactorComesToRest) {
  ASSERT_EQ(weft({"run", (fs::path(WEFT_SOURCE_DIR) / "scenes/trash_compactor.json").string(), "-o",
                  "a", "--no-preview"}),
            0)
      << err_;
  EXPECT_EQ(weft({"check", "a"}), 0) << out_ << err_;
  std::istringstream lines(text_of(at("a/steps.jsonl")));
  double most = 0, last = 0;
  std::int64_t acting = 0;
  for (std::string line; std::getline(lines, line);) {
    const Json step = Json::parse(line);
    acting = step.at("asynchronous").at("acting_pairs");
    if (!step.contains("energy")) continue;
    last = step.at("energy").at("kinetic");
    most = std::max(most, last);
  }
  EXPECT_GT(acting, 0) << "nothing holds it";
  EXPECT_LT(last, 1e-2 * most);
}

}  // namespace
}  // namespace weft::test
