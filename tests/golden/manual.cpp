#include <gtest/gtest.h>

#include <regex>
#include <string>
#include <vector>

#include "tests/golden/process.hpp"

/// Completion scripts and the manual page, which the build makes from the program's options.
namespace weft::test {
namespace {

class Manual : public Process {
 protected:
  /// Runs `weft manual KIND` into a file.
  std::string make(const std::string& kind) {
    EXPECT_EQ(weft({"manual", kind}), 0) << err_;
    return write(kind, out_);
  }
  int shell(const std::string& command) { return wait(start_words({"/bin/sh", "-c", command})); }
  bool has(const std::string& program) {
    return shell("command -v " + program + " > /dev/null") == 0;
  }
};

TEST_F(Manual, VersionNamesTheCommit) {
  ASSERT_EQ(weft({"--version"}), 0);
  EXPECT_TRUE(std::regex_match(
      out_,
      std::regex(R"(weft \d+\.\d+\.\d+ \(commit ([0-9a-f]{12}|unknown)(, with changes)?\)\n)")))
      << out_;
}

TEST_F(Manual, BashCompletes) {
  const std::string script = make("bash");
  ASSERT_EQ(shell("bash -n " + script), 0) << err_;
  const auto completed = [&](const std::string& words, int place) {
    EXPECT_EQ(wait(start_words({"/bin/bash", "-c",
                                "source " + script + "; COMP_WORDS=(" + words + "); COMP_CWORD=" +
                                    std::to_string(place) + "; _weft; echo \"${COMPREPLY[*]}\""})),
              0)
        << err_;
    return out_;
  };
  EXPECT_EQ(completed("weft ru", 1), "run\n");
  EXPECT_EQ(completed("weft --ver", 1), "--version\n");
  EXPECT_EQ(completed("weft run --resume-c", 2), "--resume-changed\n");
  EXPECT_EQ(completed("weft new a.obj --units c", 4), "cm\n");
  EXPECT_EQ(completed("weft run sma", 2), "small.json\n");
  EXPECT_EQ(completed("weft sli", 1), "\n") << "hidden";
}

TEST_F(Manual, OtherShellsRead) {
  const std::string zsh = make("zsh"), fish = make("fish");
  EXPECT_NE(text_of(zsh).find("--resume-changed["), std::string::npos);
  EXPECT_NE(text_of(fish).find("-l resume-changed "), std::string::npos);
  if (has("zsh")) {
    EXPECT_EQ(shell("zsh -n " + zsh), 0) << err_;
  }
  if (has("fish")) {
    EXPECT_EQ(shell("fish -n " + fish), 0) << err_;
  }
}

TEST_F(Manual, ThePageHasAllCommandsAndNoWarnings) {
  const std::string page = make("man");
  ASSERT_EQ(weft({"--help"}), 0);
  const std::string text = text_of(page);
  for (const char* command :
       {"new", "run", "check", "chart", "convert", "plan", "render", "info"}) {
    EXPECT_NE(out_.find(std::string("  ") + command + " "), std::string::npos) << command;
    EXPECT_NE(text.find(std::string(".SS weft ") + command + "\n"), std::string::npos) << command;
  }
  EXPECT_EQ(text.find("weft slice"), std::string::npos) << "hidden";
  if (!has("groff")) GTEST_SKIP() << "no groff";
  EXPECT_EQ(shell("groff -man -ww -z " + page), 0);
  EXPECT_EQ(err_, "");
}

}  // namespace
}  // namespace weft::test
