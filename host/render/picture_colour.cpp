#include "host/render/picture_colour.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace weft::io {
namespace {

constexpr std::size_t steps = 256;
constexpr Vec3<float> no_value{0.62f, 0.62f, 0.62f};

using Vec3d = Vec3<double>;

/// Linear sRGB of an Oklab colour.
/// @cite ottosson2020
Vec3d linear_of_oklab(double lightness, double a, double b) {
  const double l = lightness + 0.3963377774 * a + 0.2158037573 * b;
  const double m = lightness - 0.1055613458 * a - 0.0638541728 * b;
  const double s = lightness - 0.0894841775 * a - 1.2914855480 * b;
  const double l3 = l * l * l, m3 = m * m * m, s3 = s * s * s;
  return {4.0767416621 * l3 - 3.3077115913 * m3 + 0.2309699292 * s3,
          -1.2684380046 * l3 + 2.6097574011 * m3 - 0.3413193965 * s3,
          -0.0041960863 * l3 - 0.7034186147 * m3 + 1.7076147010 * s3};
}

double encoded(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

double decoded(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

/// The colour of the map at a chroma, linear; channels outside of 0..1 cannot be shown.
Vec3d map_colour(double t, double chroma) {
  const double hue = (312 - 208 * t) * std::numbers::pi / 180;
  return linear_of_oklab(0.29 + 0.63 * t, chroma * std::cos(hue), chroma * std::sin(hue));
}

/// Largest chroma that can be shown, up to a limit.
double shown_chroma(double t) {
  double low = 0, high = 0.15;
  for (int round = 0; round < 30; ++round) {
    const double chroma = 0.5 * (low + high);
    const Vec3d rgb = map_colour(t, chroma);
    const bool shown =
        std::min({rgb[0], rgb[1], rgb[2]}) >= 0 && std::max({rgb[0], rgb[1], rgb[2]}) <= 1;
    (shown ? low : high) = chroma;
  }
  return low;
}

/// Number `i` from the middle of a window, held at the ends of the map.
std::size_t neighbour(std::size_t i, int offset) {
  return static_cast<std::size_t>(
      std::clamp(static_cast<int>(i) + offset, 0, static_cast<int>(steps) - 1));
}

/// The chroma follows the border of what can be shown, but its corners would show as false edges:
/// so it is the mean over a window of the least over a window, which stays inside.
std::array<Vec3<float>, steps> make_map() {
  constexpr int window = 28;
  std::array<double, steps> most{}, least{};
  for (std::size_t i = 0; i < steps; ++i)
    most[i] = shown_chroma(static_cast<double>(i) / (steps - 1));
  for (std::size_t i = 0; i < steps; ++i) {
    least[i] = most[i];
    for (int d = -window; d <= window; ++d) least[i] = std::min(least[i], most[neighbour(i, d)]);
  }
  std::array<Vec3<float>, steps> map{};
  for (std::size_t i = 0; i < steps; ++i) {
    double chroma = 0;
    for (int d = -window; d <= window; ++d) chroma += least[neighbour(i, d)] / (2 * window + 1);
    const Vec3d rgb = map_colour(static_cast<double>(i) / (steps - 1), chroma);
    for (int k = 0; k < 3; ++k)
      map[i][k] = static_cast<float>(encoded(std::clamp(rgb[k], 0.0, 1.0)));
  }
  return map;
}

/// Entries of a table over 0..1, linear in between.
template <class Table>
Vec3<float> looked_up(const Table& table, float t) {
  const float place = std::clamp(t, 0.0f, 1.0f) * (steps - 1);
  const std::size_t i = std::min(static_cast<std::size_t>(place), steps - 2);
  const float share = place - static_cast<float>(i);
  return table[i] * (1 - share) + table[i + 1] * share;
}

/// The x whose filmic(x) is `y`: the root of a quadratic.
float inverse_filmic(float y) {
  const float a = 2.51f - 2.43f * y, b = 0.03f - 0.59f * y, c = -0.14f * y;
  return (-b + std::sqrt(b * b - 4 * a * c)) / (2 * a);
}

Vec3<float> light_of(const Vec3<float>& srgb) {
  Vec3<float> light{};
  for (int k = 0; k < 3; ++k) light[k] = inverse_filmic(std::pow(srgb[k], 2.2f));
  return light;
}

}  // namespace

Vec3<float> colour_of(float t) {
  static const std::array<Vec3<float>, steps> map = make_map();
  return std::isnan(t) ? no_value : looked_up(map, t);
}

float lightness(const Vec3<float>& srgb) {
  const double r = decoded(srgb[0]), g = decoded(srgb[1]), b = decoded(srgb[2]);
  const double l = std::cbrt(0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b);
  const double m = std::cbrt(0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b);
  const double s = std::cbrt(0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b);
  return static_cast<float>(0.2104542553 * l + 0.7936177850 * m - 0.0040720468 * s);
}

Vec<std::uint8_t, 3> bytes_of(const Vec3<float>& srgb) {
  Vec<std::uint8_t, 3> bytes{};
  for (int k = 0; k < 3; ++k)
    bytes[k] = static_cast<std::uint8_t>(std::lround(255 * std::clamp(srgb[k], 0.0f, 1.0f)));
  return bytes;
}

Vec3<float> shading::mapped_light(float t) {
  static const std::array<Vec3<float>, steps> lights = [] {
    std::array<Vec3<float>, steps> all{};
    for (std::size_t i = 0; i < steps; ++i)
      all[i] = light_of(colour_of(static_cast<float>(i) / (steps - 1)));
    return all;
  }();
  static const Vec3<float> none = light_of(no_value);
  return std::isnan(t) ? none : looked_up(lights, t);
}

}  // namespace weft::io
