#include "host/view/compensation.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace weft {
namespace {

/// Areas that differ by less than this share are taken for one.
constexpr double rounding = 1e-9;

}  // namespace

std::vector<double> compression_shares(const std::vector<double>& areas,
                                       const std::vector<unsigned char>& out,
                                       const ViewSettings& settings) {
  if (settings.compensation == BucklingCompensation::none) return {};
  double low = std::numeric_limits<double>::infinity(), high = 0;
  for (std::size_t t = 0; t < areas.size(); ++t) {
    if (out[t] == 0) continue;
    low = std::min(low, areas[t]);
    high = std::max(high, areas[t]);
  }
  const bool full = settings.compensation == BucklingCompensation::full;
  if (!(high > 0) || (!full && high - low <= rounding * high)) return {};
  std::vector<double> shares(areas.size(), 1);
  for (std::size_t t = 0; t < areas.size(); ++t)
    if (out[t] != 0)
      shares[t] =
          full ? 0 : std::pow((high - areas[t]) / (high - low), settings.compensation_power);
  return shares;
}

}  // namespace weft
