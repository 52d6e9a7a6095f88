#include "host/render/picture_legend.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <iterator>

#include "host/render/picture_colour.hpp"

namespace weft::io {
namespace {

constexpr int glyph_width = 5, glyph_height = 7, advance = 6;

/// Rows from the top; bit 4 is the left column.
struct Glyph {
  char letter;
  std::array<std::uint8_t, glyph_height> rows;
};

constexpr Glyph glyphs[] = {
    {'a', {0x00, 0x00, 0x0e, 0x01, 0x0f, 0x11, 0x0f}},
    {'b', {0x10, 0x10, 0x1e, 0x11, 0x11, 0x11, 0x1e}},
    {'c', {0x00, 0x00, 0x0e, 0x11, 0x10, 0x11, 0x0e}},
    {'d', {0x01, 0x01, 0x0f, 0x11, 0x11, 0x11, 0x0f}},
    {'e', {0x00, 0x00, 0x0e, 0x11, 0x1f, 0x10, 0x0e}},
    {'f', {0x06, 0x08, 0x1c, 0x08, 0x08, 0x08, 0x08}},
    {'g', {0x00, 0x0f, 0x11, 0x11, 0x0f, 0x01, 0x0e}},
    {'h', {0x10, 0x10, 0x1e, 0x11, 0x11, 0x11, 0x11}},
    {'i', {0x04, 0x00, 0x0c, 0x04, 0x04, 0x04, 0x0e}},
    {'j', {0x02, 0x00, 0x06, 0x02, 0x02, 0x12, 0x0c}},
    {'k', {0x10, 0x10, 0x12, 0x14, 0x18, 0x14, 0x12}},
    {'l', {0x0c, 0x04, 0x04, 0x04, 0x04, 0x04, 0x0e}},
    {'m', {0x00, 0x00, 0x1a, 0x15, 0x15, 0x15, 0x15}},
    {'n', {0x00, 0x00, 0x1e, 0x11, 0x11, 0x11, 0x11}},
    {'o', {0x00, 0x00, 0x0e, 0x11, 0x11, 0x11, 0x0e}},
    {'p', {0x00, 0x1e, 0x11, 0x11, 0x1e, 0x10, 0x10}},
    {'q', {0x00, 0x0f, 0x11, 0x11, 0x0f, 0x01, 0x01}},
    {'r', {0x00, 0x00, 0x16, 0x19, 0x10, 0x10, 0x10}},
    {'s', {0x00, 0x00, 0x0f, 0x10, 0x0e, 0x01, 0x1e}},
    {'t', {0x08, 0x08, 0x1c, 0x08, 0x08, 0x09, 0x06}},
    {'u', {0x00, 0x00, 0x11, 0x11, 0x11, 0x11, 0x0f}},
    {'v', {0x00, 0x00, 0x11, 0x11, 0x11, 0x0a, 0x04}},
    {'w', {0x00, 0x00, 0x11, 0x15, 0x15, 0x15, 0x0a}},
    {'x', {0x00, 0x00, 0x11, 0x0a, 0x04, 0x0a, 0x11}},
    {'y', {0x00, 0x11, 0x11, 0x11, 0x0f, 0x01, 0x0e}},
    {'z', {0x00, 0x00, 0x1f, 0x02, 0x04, 0x08, 0x1f}},
    {'0', {0x0e, 0x11, 0x13, 0x15, 0x19, 0x11, 0x0e}},
    {'1', {0x04, 0x0c, 0x04, 0x04, 0x04, 0x04, 0x0e}},
    {'2', {0x0e, 0x11, 0x01, 0x06, 0x08, 0x10, 0x1f}},
    {'3', {0x1e, 0x01, 0x01, 0x0e, 0x01, 0x01, 0x1e}},
    {'4', {0x02, 0x06, 0x0a, 0x12, 0x1f, 0x02, 0x02}},
    {'5', {0x1f, 0x10, 0x1e, 0x01, 0x01, 0x11, 0x0e}},
    {'6', {0x06, 0x08, 0x10, 0x1e, 0x11, 0x11, 0x0e}},
    {'7', {0x1f, 0x01, 0x02, 0x04, 0x08, 0x08, 0x08}},
    {'8', {0x0e, 0x11, 0x11, 0x0e, 0x11, 0x11, 0x0e}},
    {'9', {0x0e, 0x11, 0x11, 0x0f, 0x01, 0x02, 0x0c}},
    {'.', {0x00, 0x00, 0x00, 0x00, 0x00, 0x0c, 0x0c}},
    {'-', {0x00, 0x00, 0x00, 0x1f, 0x00, 0x00, 0x00}},
    {'+', {0x00, 0x04, 0x04, 0x1f, 0x04, 0x04, 0x00}},
    {'%', {0x18, 0x19, 0x02, 0x04, 0x08, 0x13, 0x03}},
    {'/', {0x01, 0x01, 0x02, 0x04, 0x08, 0x10, 0x10}},
    {'<', {0x02, 0x04, 0x08, 0x10, 0x08, 0x04, 0x02}},
    {'>', {0x08, 0x04, 0x02, 0x01, 0x02, 0x04, 0x08}},
    {'(', {0x02, 0x04, 0x08, 0x08, 0x08, 0x04, 0x02}},
    {')', {0x08, 0x04, 0x02, 0x02, 0x02, 0x04, 0x08}},
    {'=', {0x00, 0x00, 0x1f, 0x00, 0x1f, 0x00, 0x00}},
    {':', {0x00, 0x0c, 0x0c, 0x00, 0x0c, 0x0c, 0x00}},
};

constexpr Vec3<float> ink{0.13f, 0.13f, 0.15f};

std::uint8_t* pixel(Image& image, int x, int y) {
  return image.rgb.data() + 3 * (std::ptrdiff_t{y} * image.width + x);
}

PixelBox inside(const Image& image, const PixelBox& b) {
  return {std::max(b.left, 0), std::max(b.top, 0), std::min(b.right, image.width),
          std::min(b.bottom, image.height)};
}

/// @param cover 0: nothing changes, 1: nothing shows through
void fill(Image& image, const PixelBox& whole, const Vec3<float>& srgb, float cover) {
  const PixelBox box = inside(image, whole);
  for (int y = box.top; y < box.bottom; ++y)
    for (int x = box.left; x < box.right; ++x) {
      std::uint8_t* p = pixel(image, x, y);
      for (int k = 0; k < 3; ++k) {
        const float mixed = static_cast<float>(p[k]) * (1 - cover) + 255 * srgb[k] * cover;
        p[k] = static_cast<std::uint8_t>(std::lround(std::clamp(mixed, 0.0f, 255.0f)));
      }
    }
}

int scale_for(int width, int height) {
  return std::clamp(std::min(width / 320, height / 240), 1, 8);
}

std::string number_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

/// A tick below the bar, its number centred below it but within the bar's panel.
void draw_tick(Image& image, const PixelBox& bar, int scale, double share,
               const std::string& text) {
  const int width = bar.right - bar.left;
  const int x = bar.left + static_cast<int>(std::lround(share * (width - scale)));
  fill(image, {x, bar.bottom, x + scale, bar.bottom + 2 * scale}, ink, 1);
  const int half = (text_width(text, scale) - scale) / 2;
  const int left = std::clamp(x - half, bar.left, std::max(bar.left, bar.right - 2 * half));
  draw_text(image, left, bar.bottom + 4 * scale, text, scale, ink);
}

}  // namespace

int text_width(const std::string& text, int scale) {
  return advance * scale * static_cast<int>(text.size());
}

void draw_text(Image& image, int x, int y, const std::string& text, int scale,
               const Vec3<float>& srgb) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto* const glyph = std::find_if(std::begin(glyphs), std::end(glyphs),
                                           [&](const Glyph& g) { return g.letter == text[i]; });
    if (glyph == std::end(glyphs)) continue;
    // Letters that hang below the line fill their seven rows and are lowered.
    const int y0 = y + (std::strchr("gpqy", text[i]) != nullptr ? scale : 0);
    const int x0 = x + advance * scale * static_cast<int>(i);
    for (int row = 0; row < glyph_height; ++row)
      for (int column = 0; column < glyph_width; ++column) {
        if ((glyph->rows[static_cast<std::size_t>(row)] >> (glyph_width - 1 - column) & 1) == 0)
          continue;
        const int left = x0 + column * scale, top = y0 + row * scale;
        fill(image, {left, top, left + scale, top + scale}, srgb, 1);
      }
  }
}

PixelBox legend_bar(int width, int height) {
  const int scale = scale_for(width, height);
  const int left = 12 * scale, bottom = height - 22 * scale;
  return {left, bottom - 9 * scale, left + 132 * scale, bottom};
}

void draw_legend(Image& image, const Legend& legend) {
  const int scale = scale_for(image.width, image.height);
  const PixelBox bar = legend_bar(image.width, image.height);
  const int right = std::max(bar.right, bar.left + text_width(legend.title, scale));
  fill(image,
       {bar.left - 6 * scale, bar.top - 17 * scale, right + 6 * scale, bar.bottom + 16 * scale},
       {1, 1, 1}, 0.72f);
  draw_text(image, bar.left, bar.top - 11 * scale, legend.title, scale, ink);
  const int width = bar.right - bar.left;
  for (int i = 0; i < width; ++i)
    fill(image, {bar.left + i, bar.top, bar.left + i + 1, bar.bottom},
         colour_of(static_cast<float>(i) / static_cast<float>(width - 1)), 1);
  draw_tick(image, bar, scale, 0, (legend.more_below ? "<" : "") + number_text(legend.low));
  draw_tick(image, bar, scale, 0.5, number_text(0.5 * (legend.low + legend.high)));
  draw_tick(image, bar, scale, 1, (legend.more_above ? ">" : "") + number_text(legend.high));
}

}  // namespace weft::io
