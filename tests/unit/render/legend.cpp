#include "host/render/picture_legend.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <set>
#include <string>
#include <vector>

#include "host/render/picture_colour.hpp"

namespace weft::io {
namespace {

Image blank(int width, int height) {
  Image image{width, height, {}};
  image.rgb.assign(std::size_t{3} * static_cast<std::size_t>(width * height), 255);
  return image;
}

Vec<std::uint8_t, 3> at(const Image& image, int x, int y) {
  const std::uint8_t* p = image.rgb.data() + 3 * (y * image.width + x);
  return {p[0], p[1], p[2]};
}

/// The dots of a box, dark ones as '#', a line a row.
std::string dots(const Image& image, const PixelBox& box) {
  std::string text;
  for (int y = box.top; y < box.bottom; ++y) {
    for (int x = box.left; x < box.right; ++x) text += at(image, x, y)[0] < 128 ? '#' : '.';
    text += '\n';
  }
  return text;
}

std::string written(const std::string& text) {
  Image image = blank(text_width(text, 1) + 2, 8);
  draw_text(image, 0, 0, text, 1, {0, 0, 0});
  return dots(image, {0, 0, image.width, image.height});
}

TEST(PictureLegend, LettersAreDrawnAsTheyAre) {
  EXPECT_EQ(written("1"),
            "..#.....\n"
            ".##.....\n"
            "..#.....\n"
            "..#.....\n"
            "..#.....\n"
            "..#.....\n"
            ".###....\n"
            "........\n");
}

TEST(PictureLegend, EachLetterHasAShapeOfItsOwn) {
  const std::string letters = "abcdefghijklmnopqrstuvwxyz0123456789.-+%/<>()=:";
  std::set<std::string> shapes{written(" ")};
  for (const char c : letters) EXPECT_TRUE(shapes.insert(written(std::string(1, c))).second) << c;
}

TEST(PictureLegend, ScaleMakesDotsLarger) {
  Image image = blank(40, 40);
  draw_text(image, 3, 4, "1", 4, {0, 0, 0});
  EXPECT_EQ(dots(image, {3, 4, 3 + 20, 4 + 4}),
            std::string("........####........\n") + "........####........\n" +
                "........####........\n" + "........####........\n");
}

/// Finds a text somewhere in a picture.
bool shows(const Image& image, const std::string& text) {
  Image small = blank(text_width(text, 1) - 1, 7);
  draw_text(small, 0, 0, text, 1, {0, 0, 0});
  const std::string wanted = dots(small, {0, 0, small.width, small.height});
  for (int y = 0; y + 7 <= image.height; ++y)
    for (int x = 0; x + small.width <= image.width; ++x)
      if (dots(image, {x, y, x + small.width, y + 7}) == wanted) return true;
  return false;
}

TEST(PictureLegend, ShowsTitleAndEnds) {
  Image image = blank(320, 240);
  draw_legend(image, {"height (m)", -0.25, 1.75, false, true});
  EXPECT_TRUE(shows(image, "-0.25"));
  EXPECT_TRUE(shows(image, "0.75"));
  EXPECT_TRUE(shows(image, ">1.75"));
  EXPECT_TRUE(shows(image, "ei"));  // of the title; letters that hang low are not in seven rows
  EXPECT_TRUE(shows(image, "t (m)"));
  EXPECT_FALSE(shows(image, "<-0.25"));
  EXPECT_FALSE(shows(image, "2.75"));
}

TEST(PictureLegend, BarRunsThroughTheMap) {
  for (const auto& [width, height] : {std::pair{320, 240}, {1280, 960}}) {
    Image image = blank(width, height);
    draw_legend(image, {"strain (%)", 0, 2, true, true});
    const PixelBox bar = legend_bar(width, height);
    ASSERT_GE(bar.left, 0);
    ASSERT_LE(bar.right, width);
    ASSERT_LT(bar.bottom, height);
    const int y = (bar.top + bar.bottom) / 2;
    EXPECT_EQ(at(image, bar.left, y), bytes_of(colour_of(0)));
    EXPECT_EQ(at(image, bar.right - 1, y), bytes_of(colour_of(1)));
    EXPECT_EQ(at(image, width - 1, y), (Vec<std::uint8_t, 3>{255, 255, 255}));
  }
}

TEST(PictureLegend, TinyPicturesAreNoProblem) {
  for (const int size : {1, 7, 40}) {
    Image image = blank(size, size);
    draw_legend(image, {"gap / thickness", 0, 2, false, true});
    EXPECT_EQ(image.rgb.size(), static_cast<std::size_t>(3 * size * size));
  }
}

}  // namespace
}  // namespace weft::io
