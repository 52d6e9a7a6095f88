#include "host/render/png_file.hpp"

#include <gtest/gtest.h>
#include <png.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <string>

#include "host/base/scratch_folder.hpp"
#include "weft/error.hpp"

namespace {

namespace fs = std::filesystem;
using weft::SceneError;
using weft::io::Image;
using weft::io::write_png;

class PngFile : public testing::Test {
 protected:
  std::ptrdiff_t file_count() const {
    return std::distance(fs::directory_iterator(folder_), fs::directory_iterator());
  }

  const weft::ScratchFolder scratch_;
  const fs::path folder_ = scratch_.path();
};

Image gradient(int width, int height, unsigned seed) {
  Image image{width, height, {}};
  for (int i = 0; i < 3 * width * height; ++i)
    image.rgb.push_back(static_cast<std::uint8_t>((static_cast<unsigned>(i) * 97u + seed) % 256u));
  return image;
}

/// Reads with libpng alone, so that a fault of the writer cannot cancel out.
Image read_back(const fs::path& path) {
  png_image header;
  std::memset(&header, 0, sizeof header);
  header.version = PNG_IMAGE_VERSION;
  EXPECT_NE(png_image_begin_read_from_file(&header, path.c_str()), 0) << header.message;
  EXPECT_EQ(header.format, static_cast<png_uint_32>(PNG_FORMAT_RGB));
  header.format = PNG_FORMAT_RGB;
  Image image{static_cast<int>(header.width), static_cast<int>(header.height), {}};
  image.rgb.resize(PNG_IMAGE_SIZE(header));
  EXPECT_NE(png_image_finish_read(&header, nullptr, image.rgb.data(), 0, nullptr), 0)
      << header.message;
  return image;
}

TEST_F(PngFile, ReadsBackAsWritten) {
  for (const auto& [width, height] : {std::pair{1, 1}, {7, 3}, {64, 129}}) {
    const Image image = gradient(width, height, 5);
    write_png(folder_ / "picture.png", image);
    const Image back = read_back(folder_ / "picture.png");
    EXPECT_EQ(back.width, width);
    EXPECT_EQ(back.height, height);
    EXPECT_EQ(back.rgb, image.rgb) << width << " x " << height;
  }
}

TEST_F(PngFile, ReplacesAndLeavesNothingBeside) {
  write_png(folder_ / "picture.png", gradient(8, 8, 1));
  write_png(folder_ / "picture.png", gradient(4, 4, 2));
  EXPECT_EQ(read_back(folder_ / "picture.png").rgb, gradient(4, 4, 2).rgb);
  EXPECT_EQ(file_count(), 1);
}

TEST_F(PngFile, RefusesInconsistentImages) {
  Image missing = gradient(4, 4, 1);
  missing.rgb.pop_back();
  EXPECT_THROW(write_png(folder_ / "a.png", missing), SceneError);
  EXPECT_THROW(write_png(folder_ / "a.png", Image{}), SceneError);
  EXPECT_THROW(write_png(folder_ / "a.png", Image{-1, -1, {0, 0, 0}}), SceneError);
  EXPECT_EQ(file_count(), 0);
}

TEST_F(PngFile, NamesThePlaceThatCannotBeWritten) {
  const fs::path path = folder_ / "missing" / "picture.png";
  try {
    write_png(path, gradient(2, 2, 1));
    FAIL() << "a missing folder was accepted";
  } catch (const SceneError& error) {
    EXPECT_NE(std::string(error.what()).find(path.string()), std::string::npos) << error.what();
  }
}

TEST_F(PngFile, FailureToRenameLeavesNothingBeside) {
  fs::create_directories(folder_ / "taken.png" / "inside");
  EXPECT_THROW(write_png(folder_ / "taken.png", gradient(2, 2, 1)), SceneError);
  EXPECT_TRUE(fs::is_directory(folder_ / "taken.png"));
  EXPECT_EQ(file_count(), 1);
}

/// A picture of another writer that was killed half way must neither block nor be touched.
TEST_F(PngFile, StepsAroundALeftover) {
  write_png(folder_ / "picture.png.0.part", gradient(2, 2, 9));
  write_png(folder_ / "picture.png", gradient(4, 4, 3));
  EXPECT_EQ(read_back(folder_ / "picture.png").rgb, gradient(4, 4, 3).rgb);
  EXPECT_EQ(read_back(folder_ / "picture.png.0.part").rgb, gradient(2, 2, 9).rgb);
}

}  // namespace
