#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <ostream>
#include <set>
#include <string>

#include "tests/fuzz/targets.hpp"
#include "tests/unit/io/directories.hpp"

namespace weft::fuzz {

/// For GoogleTest, which looks for it beside the type.
void PrintTo(const Target& target, std::ostream* out);
void PrintTo(const Target& target, std::ostream* out) {
  *out << target.name;
}

namespace {

namespace fs = std::filesystem;

fs::path seeds() {
  return io::repository_root() / "tests" / "fuzz" / "seeds";
}

std::string bytes_of(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  EXPECT_TRUE(stream) << path;
  return {std::istreambuf_iterator<char>(stream), {}};
}

class FuzzSeeds : public testing::TestWithParam<Target> {};

TEST_P(FuzzSeeds, AreReadOrRefused) {
  std::size_t count = 0;
  for (const auto& entry : fs::directory_iterator(seeds() / GetParam().name)) {
    SCOPED_TRACE(entry.path().string());
    EXPECT_NO_THROW(GetParam().run(bytes_of(entry.path())));
    ++count;
  }
  EXPECT_GT(count, 0u);
}

INSTANTIATE_TEST_SUITE_P(Of, FuzzSeeds, testing::ValuesIn(targets),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(FuzzTargets, HaveSeedsAndSeedsHaveTargets) {
  std::set<std::string> names, folders;
  for (const Target& target : targets) names.emplace(target.name);
  for (const auto& entry : fs::directory_iterator(seeds()))
    folders.insert(entry.path().filename().string());
  EXPECT_EQ(names, folders);
}

}  // namespace
}  // namespace weft::fuzz
