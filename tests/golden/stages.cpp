// weft_bench_stages, which is beside weft where benchmarks are built: what it times is the step
// that a run does from there.
#include "tests/golden/process.hpp"

namespace weft::test {
namespace {

class Stages : public Process {
 protected:
  void SetUp() override {
    Process::SetUp();
    if (!fs::exists(program_)) GTEST_SKIP() << "weft_bench_stages is not built: NOT TESTED";
  }
  int stages(const std::vector<std::string>& more) {
    std::vector<std::string> words{program_.string(), "--scene", "small.json"};
    words.insert(words.end(), more.begin(), more.end());
    return wait(start_words(words));
  }
  Json json(const std::string& name) const { return Json::parse(text_of(at(name))); }

  const fs::path program_ = fs::path(WEFT_PROGRAM).parent_path() / "weft_bench_stages";
};

TEST_F(Stages, AreThoseOfARunOnAnyNumberOfRanks) {
  ASSERT_EQ(stages({"--steps", "24", "--device", "cpu:1", "--device", "cpu:3", "--repeats", "3",
                    "--json", "now.json"}),
            0)
      << err_;
  ASSERT_EQ(stages({"--steps", "25", "--device", "cpu:2", "--repeats", "1", "--json", "next.json"}),
            0)
      << err_;
  const Json now = json("now.json");
  const Json next = json("next.json").at("state");
  EXPECT_EQ(now.at("state").at("step"), 24);
  EXPECT_NE(now.at("state").at("state_hash"), next.at("state_hash"));
  EXPECT_TRUE(now.at("hashes_agree"));
  ASSERT_EQ(now.at("series").size(), 2u);
  for (const Json& series : now.at("series")) {
    EXPECT_EQ(series.at("peak_device_bytes").size(), series.at("ranks"));
    ASSERT_EQ(series.at("samples").size(), 3u);
    for (const Json& sample : series.at("samples")) {
      EXPECT_EQ(sample.at("state_hash"), next.at("state_hash"));
      EXPECT_EQ(sample.at("counts"), now.at("series")[0].at("counts"));
      EXPECT_GT(sample.at("counts").at("contacts"), 0);
      EXPECT_GE(sample.at("counts").at("broad_phases"), 1);
      const Json& ms = sample.at("ms");
      for (const char* stage : {"assembly", "contacts", "detection", "solves"})
        EXPECT_GT(ms.at(stage), 0.0) << stage;
      EXPECT_NEAR(ms.at("collisions").get<double>(),
                  ms.at("contacts").get<double>() + ms.at("searches").get<double>() +
                      ms.at("detection").get<double>(),
                  1e-9);
    }
    for (const Json& stage : series.at("stages")) {
      EXPECT_LE(stage.at("ms").at("min"), stage.at("ms").at("median"));
      EXPECT_LE(stage.at("ms").at("median"), stage.at("ms").at("max"));
    }
  }
  EXPECT_EQ(now.at("series")[0].at("stages").at("assembly").at("speed_up_over_first"), 1.0);
}

TEST_F(Stages, GoOnFromACheckpoint) {
  ASSERT_EQ(stages({"--smoke", "--steps", "24", "--save", "state", "--json", "made.json"}), 0)
      << err_;
  ASSERT_EQ(stages({"--smoke", "--resume", "state", "--json", "read.json"}), 0) << err_;
  const Json made = json("made.json"), read = json("read.json");
  EXPECT_EQ(made.at("state").at("state_hash"), read.at("state").at("state_hash"));
  EXPECT_EQ(made.at("series")[0].at("samples")[0].at("state_hash"),
            read.at("series")[0].at("samples")[0].at("state_hash"));
}

TEST_F(Stages, RefuseNonsenseInOneLine) {
  for (const std::vector<std::string>& words :
       std::vector<std::vector<std::string>>{{"--resume", "missing"},
                                             {"--resume", "small.json", "--steps", "3"},
                                             {"--device", "cpu:0"},
                                             {"--repeats", "0"},
                                             {"--steps", "-1"},
                                             {"--set", "method.type=asynchronous"},
                                             {"--set", "method.implicit.sleep_distance=0.001"}}) {
    EXPECT_EQ(stages(words), 2) << words.back();
    EXPECT_EQ(line_count(err_), 1) << err_;
  }
}

}  // namespace
}  // namespace weft::test
