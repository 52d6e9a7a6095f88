// The program on a disk that is full: exit code 2 and one line that names the file. And the program
// of the table of stability, in parts.
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/golden/process.hpp"

namespace weft::test {
namespace {

class FullDisk : public Process {
 protected:
  /// Runs the program with files of up to `blocks` of 1024 bytes.
  int run_with(int blocks) {
    // Writing more is an error, as on a full disk, rather than a signal.
    write("run.sh",
          "cd '" + directory_.string() + "'\n(trap '' XFSZ; ulimit -f " + std::to_string(blocks) +
              "; exec '" + WEFT_PROGRAM +
              "' run small.json -o out --overwrite --no-preview 2>&1 >/dev/null) | cat >stderr\n"
              "exit ${PIPESTATUS[0]}\n");
    const int status = std::system(("bash '" + at("run.sh").string() + "'").c_str());
    err_ = text_of(at("stderr"));
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
};

TEST_F(FullDisk, IsABadInputThatNamesTheFile) {
  // Nothing fits, the first frame of the obstacle does not, a frame of the cloth does not.
  for (const int blocks : {0, 8, 40}) {
    const int code = run_with(blocks);
    ASSERT_EQ(code, 2) << blocks << " blocks: " << err_;
    EXPECT_NE(err_.find("out/"), std::string::npos) << err_;
    EXPECT_EQ(line_count(err_), 1) << err_;
  }
  ASSERT_EQ(run_with(100000), 0) << err_;
}

/// weft_bench_stability, which is beside weft where benchmarks are built.
class StabilityRuns : public Process {
 protected:
  int stability(const std::vector<std::string>& more) {
    std::vector<std::string> words{program_.string(), "three_on_an_edge", "--method",
                                   "implicit",        "--json",           "runs.json"};
    words.insert(words.end(), more.begin(), more.end());
    return wait(start_words(words));
  }
  Json runs() const { return Json::parse(text_of(at("runs.json"))).at("runs"); }

  const fs::path program_ = fs::path(WEFT_PROGRAM).parent_path() / "weft_bench_stability";
};

TEST_F(StabilityRuns, GoOnWhereTheyStopped) {
  if (!fs::exists(program_)) GTEST_SKIP() << "weft_bench_stability is not built: NOT TESTED";
  ASSERT_EQ(stability({"--first", "3", "--jitters", "2"}), 0) << err_;
  const Json first = runs();
  ASSERT_EQ(first.size(), 2u);
  EXPECT_EQ(first[0].at("seed"), 3);
  EXPECT_EQ(first[1].at("outcome"), "refused");
  // Times are of the first call: nothing that was there is run again.
  ASSERT_EQ(stability({"--first", "3", "--jitters", "3", "--resume"}), 0) << err_;
  const Json all = runs();
  ASSERT_EQ(all.size(), 3u);
  for (std::size_t k = 0; k < 2; ++k) EXPECT_EQ(all[k], first[k]);
  EXPECT_EQ(all[2].at("seed"), 5);
  // Within another limit they would be other runs.
  EXPECT_EQ(stability({"--first", "3", "--limit", "7", "--resume"}), 2);
  EXPECT_NE(err_.find("runs.json: --resume: "), std::string::npos) << err_;
  EXPECT_EQ(line_count(err_), 1) << err_;
}

}  // namespace
}  // namespace weft::test
