// The program on a disk that is full: exit code 2 and one line that names the file.
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "tests/golden/process.hpp"

namespace weft::test {
namespace {

class FullDisk : public Process {
 protected:
  /// Runs the program with files of up to `blocks` of 1024 bytes.
  int run_with(int blocks) {
    // Writing more is an error, as on a full disk, rather than a signal.
    write("run.sh", "cd '" + directory_.string() + "'\n(trap '' XFSZ; ulimit -f " +
                        std::to_string(blocks) + "; exec '" + WEFT_PROGRAM +
                        "' run small.json -o out --no-preview 2>&1 >/dev/null) | cat >stderr\n"
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

}  // namespace
}  // namespace weft::test
