#include "host/io/mesh/child_trial.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <atomic>
#include <cstddef>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include "weft/error.hpp"

namespace weft::io {
namespace {

using testing::HasSubstr;

std::string refusal(const std::function<void()>& read) {
  try {
    try_in_child("nowhere.glb", "a mesh", read);
  } catch (const SceneError& error) {
    return error.what();
  }
  return "";
}

TEST(ChildTrial, LeavesThisProcessAsItWas) {
  int value = 1;
  EXPECT_EQ(refusal([&] { value = 2; }), "");
  EXPECT_EQ(value, 1);
}

TEST(ChildTrial, HandsOnWhatIsThrown) {
  EXPECT_EQ(refusal([] { throw SceneError("x.glb: no mesh"); }), "x.glb: no mesh");
  const std::string much(100'000, 'm');
  EXPECT_EQ(refusal([&] { throw SceneError(much); }), much.substr(0, 4000));
}

TEST(ChildTrial, SurvivesACrash) {
  EXPECT_THAT(refusal([] { ::raise(SIGSEGV); }),
              HasSubstr("nowhere.glb: cannot read as a mesh: the file is damaged"));
  EXPECT_THAT(refusal([] { ::raise(SIGABRT); }), HasSubstr("signal 6"));
}

TEST(ChildTrial, PrintsNothing) {
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  EXPECT_EQ(refusal([] {
              std::puts("out");
              std::fflush(stdout);
              std::fputs("err", stderr);
            }),
            "");
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

#ifndef __SANITIZE_ADDRESS__
TEST(ChildTrial, BoundsMemory) {
  EXPECT_NE(refusal([] { std::vector<char>(std::size_t{5} << 30).front() = 1; }), "");
}
#endif

TEST(ChildTrial, SlowBoundsTime) {
  EXPECT_THAT(refusal([] {
                std::atomic<unsigned> rounds{0};
                while (true) ++rounds;
              }),
              HasSubstr("takes more than 5 s"));
}

}  // namespace
}  // namespace weft::io
