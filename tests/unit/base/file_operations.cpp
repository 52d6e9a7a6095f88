#include "host/base/file_operations.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <functional>

#include "host/base/scratch_folder.hpp"
#include "host/base/temporary_file.hpp"
#include "weft/error.hpp"

namespace weft {
namespace {

void touch(const std::filesystem::path& path) {
  std::ofstream(path) << "x";
}

TEST(FileOperations, TellWhatIsThere) {
  const ScratchFolder folder;
  touch(folder / "file");
  EXPECT_TRUE(is_there(folder / "file"));
  EXPECT_TRUE(is_file(folder / "file"));
  EXPECT_FALSE(is_folder(folder / "file"));
  EXPECT_TRUE(is_folder(folder.path()));
  EXPECT_FALSE(is_file(folder.path()));
  EXPECT_FALSE(is_there(folder / "file" / "below"));
}

TEST(FileOperations, FilesComeInTheOrderOfTheirNames) {
  const ScratchFolder folder;
  for (const char* name : {"b", "a", "c"}) touch(folder / name);
  std::filesystem::create_directory(folder / "aa");
  EXPECT_EQ(files_in(folder.path()),
            (std::vector<std::filesystem::path>{folder / "a", folder / "b", folder / "c"}));
  EXPECT_TRUE(files_in(folder / "nowhere").empty());
}

TEST(FileOperations, NameTheFileThatFails) {
  const ScratchFolder folder;
  std::filesystem::create_directory(folder / "full");
  touch(folder / "full" / "file");
  remove_file(folder / "nothing");
  for (const auto& act : std::initializer_list<std::function<void()>>{
           [&] { remove_file(folder / "full"); },
           [&] { rename_file(folder / "nothing", folder / "full"); },
           [&] { write_all(folder / "full", -1, "x"); }}) {
    try {
      act();
      ADD_FAILURE() << "not refused";
    } catch (const SceneError& error) {
      EXPECT_EQ(std::string(error.what()).find((folder / "full").string() + ": cannot "), 0u)
          << error.what();
    }
  }
}

TEST(TemporaryFile, GoesUnlessItGotItsName) {
  const ScratchFolder folder;
  {
    const TemporaryFile lost(folder / "lost"), kept(folder / "kept.tmp");
    touch(lost.path);
    touch(kept.path);
    rename_file(kept.path, folder / "kept");
  }
  EXPECT_FALSE(is_there(folder / "lost"));
  EXPECT_TRUE(is_there(folder / "kept"));
}

}  // namespace
}  // namespace weft
