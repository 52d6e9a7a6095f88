#include "host/view/compensation.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace weft {

std::vector<double> compression_shares(const std::vector<double>& areas,
                                       const std::vector<AreaRange>& ranges,
                                       const std::vector<unsigned char>& out,
                                       const ViewSettings& settings) {
  if (settings.compensation == BucklingCompensation::none) return {};
  const bool full = settings.compensation == BucklingCompensation::full;
  std::vector<double> shares(areas.size(), 1);
  for (std::size_t t = 0; t < areas.size(); ++t) {
    const auto& [least, greatest] = ranges[t];
    if (out[t] == 0) continue;
    if (full)
      shares[t] = 0;
    else if (greatest > least)
      shares[t] = std::pow(std::clamp((greatest - areas[t]) / (greatest - least), 0.0, 1.0),
                           settings.compensation_power);
  }
  if (std::all_of(shares.begin(), shares.end(), [](double share) { return share == 1; })) return {};
  return shares;
}

}  // namespace weft
