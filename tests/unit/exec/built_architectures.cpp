#include "weft/exec/built_architectures.hpp"

#include <gtest/gtest.h>

#include <utility>

namespace weft {
namespace {

/// List of release builds, see third_party/cuda.cmake.
constexpr const char* release = "80-real,86-real,89-real,90,120";

bool fits(const char* built, int major, int minor) {
  return missing_architecture(built, "cuda:0", major, minor).empty();
}

TEST(BuiltArchitectures, ReleasesRunFromAmpereOn) {
  for (const auto& [major, minor] : {std::pair(8, 0),
                                     {8, 6},
                                     {8, 7},
                                     {8, 9},
                                     {9, 0},
                                     {10, 0},
                                     {10, 3},
                                     {12, 0},
                                     {12, 1},
                                     {13, 0}})
    EXPECT_TRUE(fits(release, major, minor)) << major << "." << minor;
  for (const auto& [major, minor] : {std::pair(6, 1), {7, 0}, {7, 5}})
    EXPECT_FALSE(fits(release, major, minor)) << major << "." << minor;
}

TEST(BuiltArchitectures, MachineCodeStaysWithinAMajorNumber) {
  EXPECT_TRUE(fits("86-real", 8, 9));
  EXPECT_FALSE(fits("86-real", 8, 0));
  EXPECT_FALSE(fits("86-real", 9, 0));
  EXPECT_TRUE(fits("86-virtual", 12, 0));
  EXPECT_FALSE(fits("86-virtual", 8, 0));
  EXPECT_TRUE(fits("90", 12, 0)) << "PTX is compiled by the driver";
  EXPECT_FALSE(fits("120-real", 9, 0));
  EXPECT_TRUE(fits("90a-real", 9, 0));
  EXPECT_FALSE(fits("90a", 10, 0));
}

TEST(BuiltArchitectures, UnknownWordsRefuseNothing) {
  for (const char* built : {"", "native", "all", "all-major", "80-real,native"})
    EXPECT_TRUE(fits(built, 7, 5)) << built;
}

TEST(BuiltArchitectures, TheMessageIsOneLineThatSaysWhatToDo) {
  EXPECT_EQ(missing_architecture("80-real,90", "cuda:1, NVIDIA T4", 7, 5),
            "cuda:1, NVIDIA T4 has compute capability 7.5, for which this build of weft has no "
            "code; it has 8.0, 9.0; build with CUDAARCHS=75, or use --device cpu");
}

}  // namespace
}  // namespace weft
