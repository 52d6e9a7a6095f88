// The program on a disk that is full: exit code 2 and one line that names the file.
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "tests/golden/process.hpp"

namespace weft::test {
namespace {

class FullDisk : public Process {
 protected:
  /// Runs the program with files of up to `blocks` of 512 bytes.
  int run_with(int blocks) {
    // Writing more is an error, as on a full disk, rather than a signal.
    const std::string command = "cd '" + directory_.string() + "' && trap '' XFSZ && ulimit -f " +
                                std::to_string(blocks) + " && exec '" + WEFT_PROGRAM +
                                "' run small.json -o out --no-preview >stdout 2>stderr";
    const int status = std::system(("bash -c \"" + command + "\"").c_str());
    out_ = text_of(at("stdout"));
    err_ = text_of(at("stderr"));
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
};

TEST_F(FullDisk, IsABadInputThatNamesTheFile) {
  // None fits, the scene does, frames do, checkpoints do not; all do.
  for (const int blocks : {0, 2, 8, 20, 40}) {
    const int code = run_with(blocks);
    ASSERT_EQ(code, 2) << blocks << " blocks: " << err_;
    EXPECT_NE(err_.find("out/"), std::string::npos) << err_;
    EXPECT_EQ(line_count(err_), 1) << err_;
  }
  ASSERT_EQ(run_with(100000), 0) << err_;
}

}  // namespace
}  // namespace weft::test
