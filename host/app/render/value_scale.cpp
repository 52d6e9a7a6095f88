#include "host/app/render/value_scale.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace weft::app {
namespace {

std::vector<float> finite(const io::CornerValues& values) {
  std::vector<float> all;
  for (const auto& cloth : values) all.insert(all.end(), cloth.begin(), cloth.end());
  std::erase_if(all, [](float x) { return !std::isfinite(x); });
  return all;
}

}  // namespace

std::optional<Extent> extent_of(const io::CornerValues& values) {
  const std::vector<float> all = finite(values);
  if (all.empty()) return std::nullopt;
  const auto [low, high] = std::minmax_element(all.begin(), all.end());
  return Extent{*low, *high};
}

double torn_triangles_apart(const io::CornerValues& values) {
  std::vector<float> all = finite(values);
  const std::size_t last = all.size() - 1;
  const auto high = all.begin() + static_cast<std::ptrdiff_t>(last - last / 200);
  std::nth_element(all.begin(), high, all.end());
  return *high;
}

double rounded_up(double value) {
  if (!(value > 0)) return value;
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 1);
  return std::ceil(value / unit - 1e-9) * unit;
}

}  // namespace weft::app
