#include "host/app/view/quantise.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace weft::app {
namespace {

/// The nearest of `steps` + 1 places from `low` to `high`.
int step_of(double value, double low, double high, int steps) {
  const double width = high - low;
  const double place = width > 0 ? (value - low) / width : 0;
  return static_cast<int>(std::lround(std::clamp(place, 0.0, 1.0) * steps));
}

}  // namespace

double largest_error(const Aabb& box) {
  return box.longest_side() / position_steps / 2;
}

void append_positions(std::string& bytes, const std::vector<Vec3<double>>& positions,
                      const Aabb& box) {
  bytes.reserve(bytes.size() + 6 * positions.size());
  for (const Vec3<double>& p : positions)
    for (int k = 0; k < 3; ++k) {
      const int step = step_of(p[k], box.lo[k], box.hi[k], position_steps);
      bytes += static_cast<char>(step & 0xff);
      bytes += static_cast<char>(step >> 8);
    }
}

void append_levels(std::string& bytes, const std::vector<float>& values, double low, double high) {
  bytes.reserve(bytes.size() + values.size());
  for (const float value : values)
    bytes +=
        static_cast<char>(std::isnan(value) ? no_level : step_of(value, low, high, no_level - 1));
}

std::string base64(std::string_view bytes) {
  constexpr std::string_view digits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    unsigned group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (k < count ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k)
      text += k <= count ? digits[group >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

}  // namespace weft::app
