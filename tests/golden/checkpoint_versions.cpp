#include <gtest/gtest.h>

#include <string>

#include "tests/golden/process.hpp"

/// Which weft wrote a checkpoint, and who reads it.
namespace weft::test {
namespace {

class CheckpointVersions : public Process {
 protected:
  /// A checkpoint of this program, with another number of the format in its header.
  std::string forged(char format) {
    if (!fs::exists(at("a"))) {
      EXPECT_EQ(run("a", {"--frames", "2"}), 0) << err_;
    }
    std::string bytes = text_of(at("a/checkpoint_00002.weft"));
    EXPECT_EQ(bytes.substr(0, 4), "WEFT");
    bytes[4] = format;
    return write("forged.weft", bytes);
  }
  int resume(const std::string& file) {
    return weft({"run", "small.json", "-o", "b", "--overwrite", "--resume", file, "--frames", "3"});
  }
};

TEST_F(CheckpointVersions, OthersAreRefusedByName) {
  const std::string mine = "allowed: 4, of weft 0.2.x\n";
  for (const auto& [format, name] : {std::pair<char, const char*>{2, "2, of weft 0.1.0;"},
                                     {3, "3, of a build between weft 0.1.0 and 0.2.0;"},
                                     {9, "9, of a later weft;"}}) {
    EXPECT_EQ(resume(forged(format)), 2);
    EXPECT_EQ(line_count(err_), 1) << err_;
    EXPECT_NE(err_.find("checkpoint version: " + std::string(name)), std::string::npos) << err_;
    EXPECT_TRUE(err_.ends_with(mine)) << err_;
  }
}

/// The format belongs to the minor version: whatever its patch version, a weft 0.2 reads format 4.
TEST_F(CheckpointVersions, ThoseOfTheSameMinorVersionAreRead) {
  EXPECT_EQ(resume(forged(4)), 0) << err_;
  ASSERT_EQ(weft({"--version"}), 0);
  EXPECT_TRUE(out_.starts_with("weft 0.2."))
      << "the next minor version says in host/state/checkpoint.cpp "
         "which format it has";
}

}  // namespace
}  // namespace weft::test
