#pragma once

#include <string>

#include "host/render/png_file.hpp"
#include "weft/core/vec.hpp"

/// Words and scales on pictures.
namespace weft::io {

/// Rectangle of pixels: left, top included, right and bottom not.
struct PixelBox {
  int left = 0, top = 0, right = 0, bottom = 0;
};

/// What the colours of a picture stand for.
struct Legend {
  std::string title;         ///< with the unit, in lower case
  double low = 0, high = 1;  ///< numbers at the two ends of the colour map
  bool more_below = false;   ///< smaller numbers have the colour of `low`
  bool more_above = false;   ///< larger numbers have the colour of `high`
};

/// Width of a text [pixels], with the space after its last letter.
int text_width(const std::string& text, int scale);

/// Writes a text in letters of 5 x 7 dots; what is outside of the picture is left out. Lower case,
/// digits and . - + % / < > ( ) = : are known, other letters leave a gap.
/// @param x, y  [pixels] left and top of the first letter
/// @param scale [pixels] of a dot
void draw_text(Image& image, int x, int y, const std::string& text, int scale,
               const Vec3<float>& srgb);

/// Where draw_legend() puts the colour bar of a picture of this size.
PixelBox legend_bar(int width, int height);

/// Puts a scale into the lower left corner: title, colour bar, numbers at its ends and its middle.
void draw_legend(Image& image, const Legend& legend);

}  // namespace weft::io
