#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "tests/golden/process.hpp"

/// Small doors of the program: help, scenes by name, and what --need promises.
namespace weft::test {
namespace {

class CommandLine : public Process {
 protected:
  /// Expects one line on standard error.
  void expect_refused(const std::vector<std::string>& words, const std::string& text) {
    EXPECT_EQ(weft(words), 2) << out_ << err_;
    EXPECT_EQ(line_count(err_), 1) << err_;
    EXPECT_NE(err_.find(text), std::string::npos) << err_;
    EXPECT_FALSE(err_.ends_with("allowed: \n")) << err_;
  }
};

TEST_F(CommandLine, HelpIsAWordToo) {
  ASSERT_EQ(weft({"--help"}), 0);
  const std::string whole = out_;
  ASSERT_EQ(weft({"run", "--help"}), 0);
  const std::string of_run = out_;
  EXPECT_EQ(weft({"help"}), 0);
  EXPECT_EQ(out_, whole);
  EXPECT_EQ(weft({"help", "run"}), 0);
  EXPECT_EQ(out_, of_run);
  expect_refused({"help", "rum"}, "subcommand: rum; allowed: new, run, ");
}

TEST_F(CommandLine, MistakesAreOneLine) {
  expect_refused({}, "weft: ");
  expect_refused({"run"}, "scene is required; see weft run --help");
  expect_refused({"run", "small.json", "--fraems", "3"},
                 "run: --fraems is not expected; did you mean \"--frames\"?");
  expect_refused({"run", "small.json", "--out=x"}, "did you mean \"--output\"?");
  expect_refused({"run", "small.json", "more"}, "run: more is not expected; see weft run");
  expect_refused({"rnu", "small.json"}, "did you mean \"run\"?");
  expect_refused({"run", "small.json", "--workers", "none"}, "--workers");
  expect_refused({"run", "small.json", "--set", "pins.0.cloth=a\nb"}, "pins");
  expect_refused({"run", "small.json", "-o", ""}, "--output: nothing; allowed: a value");
  EXPECT_FALSE(fs::exists(at("out")));
  expect_refused({"run", "small.json", "--report", "./small.json"},
                 "--report: the scene; allowed: another file");
  expect_refused({"plan", "small.json", "--json", "small.json"},
                 "--json: the scene; allowed: another");
  expect_refused({"run", "small.json", "--set", "method.foo=1"},
                 "allowed: type, integrator, implicit, time_parallel, view\n");
  expect_refused({"run", "small.json", "--set", "obstacles.1.name=b"},
                 "allowed: 0, the only place");
  expect_refused({"plan", "small.json", "--probe", "-1"},
                 "--probe: \"-1\"; allowed: a number from 0 to 1e9; see weft");
  expect_refused({"run", "small.json", "--time-limit", "nan"},
                 "allowed: a number from 0.001 to 1e9");
  expect_refused({"run", "small.json", "--workers", "1.5"},
                 "allowed: an integer from 1 to 1000000");
}

TEST_F(CommandLine, PlansWarnAsRunsDo) {
  EXPECT_EQ(weft({"plan", "small.json", "--probe", "0", "--set", "time.step=5"}), 0) << err_;
  EXPECT_EQ(err_.find("weft: warning: time.step: 5 s is longer than a frame of 0.04 s"), 0u)
      << err_;
}

TEST_F(CommandLine, LostOutputIsNoSuccess) {
  for (const char* words : {"info", "info --fabrics", "run --help"})
    EXPECT_EQ(wait(start_words(
                  {"/bin/sh", "-c", WEFT_PROGRAM + std::string(" ") + words + " > /dev/full"})),
              2)
        << words;
  EXPECT_NE(err_.find("weft: standard output: cannot write: No space left"), std::string::npos)
      << err_;
}

TEST_F(CommandLine, ScenesHaveNames) {
  const std::vector<std::string> one_frame{"--frames", "1", "--no-preview", "--set",
                                           "triangles=100"};
  const auto run_named = [&](const std::string& name) {
    std::vector<std::string> words{"run", name, "-o", "out", "--overwrite"};
    words.insert(words.end(), one_frame.begin(), one_frame.end());
    const int code = weft(words);
    return code == 0 ? Json::parse(text_of(at("out/scene.json"))).at("name").get<std::string>()
                     : err_;
  };
  EXPECT_EQ(run_named("drape"), "drape") << "a shipped scene";
  EXPECT_EQ(run_named("drape.json"), "drape");
  std::string own = text_of(fs::path(WEFT_SOURCE_DIR) / "scenes" / "drape.json");
  own.insert(own.find('{') + 1, "\"name\": \"mine\", ");
  if (const std::size_t old = own.find("\"name\": \"drape\","); old != std::string::npos)
    own.erase(old, std::string("\"name\": \"drape\",").size());
  write("drape.json", own);
  EXPECT_EQ(run_named("drape"), "mine") << "a file wins";
  fs::create_directory(at("flag"));
  EXPECT_EQ(run_named("flag"), "flag") << "a folder is no scene";
  expect_refused({"run", "darpe"}, "shipped scenes: bowline, bullet, cards, ");
  expect_refused({"run", "darpe"}, "did you mean \"drape\"?");
  expect_refused({"run", "no/drape"}, "no/drape");
  expect_refused({"plan", "flga"}, "did you mean \"flag\"?");
  expect_refused({"chart", "flga", "-o", "c"}, "did you mean \"flag\"?");
}

TEST_F(CommandLine, NeedsAreStatedInPercentOrBelowOne) {
  for (const char* need : {"error<5", "error<1", "error<101%", "error<0", "error<nan", "error<-1%",
                           "error", "intersections=1", ","})
    expect_refused(run_arguments("a", {"--need", need}), "--need: ");
}

/// The cells of the scene are given, so that no other mesh tells the error of this one.
TEST_F(CommandLine, WhatIsNotKnownIsNotMet) {
  EXPECT_EQ(run("a", {"--frames", "1", "--need", "error<50%"}), 4) << out_ << err_;
  EXPECT_NE(err_.find("unknown: mesh"), std::string::npos) << err_;
  EXPECT_EQ(out_.find("target met"), std::string::npos) << out_;
  const Json found = Json::parse(text_of(at("a/need.json")));
  EXPECT_EQ(found.at("met"), false);
  EXPECT_EQ(found.at("unknown"), Json::array({"mesh"}));
  EXPECT_TRUE(found.at("error").is_null());
  EXPECT_TRUE(found.at("error_by_mesh").is_null());
  EXPECT_TRUE(found.at("error_by_step").is_number());

  EXPECT_EQ(run("a", {"--frames", "1", "--need", "intersections=0"}), 0) << err_;
  const Json clean = Json::parse(text_of(at("a/need.json")));
  EXPECT_EQ(clean.at("met"), true);
  EXPECT_EQ(clean.at("unknown"), Json::array());
}

/// No need.json of an earlier run may stand where this one fails.
TEST_F(CommandLine, ARunThatFailsMeetsNothing) {
  EXPECT_EQ(run("a", {"--frames", "1", "--need", "intersections=0"}), 0) << err_;
  ASSERT_TRUE(fs::exists(at("a/need.json")));
  EXPECT_EQ(run("a", {"--frames", "1", "--need", "intersections=0", "--experimental",
                      "solver.max_iterations=1", "--set", "solver.tolerance=1e-12",
                      "--experimental", "contact.substep_bisections=0"}),
            4)
      << out_ << err_;
  EXPECT_FALSE(fs::exists(at("a/need.json")));
}

}  // namespace
}  // namespace weft::test
