#include "host/base/atomic_file.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>

#include "host/base/scratch_folder.hpp"
#include "weft/error.hpp"

namespace weft {
namespace {

namespace fs = std::filesystem;

class AtomicFile : public testing::Test {
 protected:
  static std::string content(const fs::path& path) {
    std::ifstream stream(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  std::size_t file_count() const {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(directory_), fs::directory_iterator()));
  }

  const ScratchFolder folder_;
  const fs::path directory_ = folder_.path();
};

TEST_F(AtomicFile, WritesAndReplaces) {
  const fs::path path = directory_ / "a.txt";
  write_file_atomically(path, std::string_view("one\0two", 7));
  EXPECT_EQ(content(path), std::string("one\0two", 7));
  write_file_atomically(path, "", Durability::none);
  EXPECT_EQ(content(path), "");
  EXPECT_EQ(file_count(), 1u);
}

TEST_F(AtomicFile, NamesTheFileThatCannotBeWritten) {
  const fs::path path = directory_ / "none" / "a.txt";
  try {
    write_file_atomically(path, "text");
    ADD_FAILURE();
  } catch (const SceneError& error) {
    EXPECT_EQ(std::string(error.what()).find(path.string() + ": cannot open"), 0u) << error.what();
  }
}

TEST_F(AtomicFile, LeavesNothingBehindOnFailure) {
  fs::create_directories(directory_ / "taken");
  EXPECT_THROW(write_file_atomically(directory_ / "taken", "text"), SceneError);
  EXPECT_EQ(file_count(), 1u);
}

TEST_F(AtomicFile, FollowsLinks) {
  fs::create_directories(directory_ / "real");
  fs::create_symlink(directory_ / "real" / "b.txt", directory_ / "link");
  write_file_atomically(directory_ / "link", "text");
  EXPECT_TRUE(fs::is_symlink(directory_ / "link"));
  EXPECT_EQ(content(directory_ / "real" / "b.txt"), "text");
}

TEST_F(AtomicFile, DoesNotReplaceDevices) {
  fs::create_symlink("/dev/null", directory_ / "sink");
  write_file_atomically(directory_ / "sink", "text");
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

}  // namespace
}  // namespace weft
