#include "host/implicit/work_cuts.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace weft {
namespace {

/// What asking takes where nothing is found, over what it takes on average to look at what is
/// found: a share of the cloth without pairs is not free.
constexpr double asking_share = 0.25;

}  // namespace

WorkCuts::WorkCuts(int ranks) {
  for (int r = 0; r <= ranks; ++r)
    begin_.push_back(
        static_cast<std::uint32_t>(std::uint64_t{whole_table} * static_cast<std::uint64_t>(r) /
                                   static_cast<std::uint64_t>(ranks)));
}

void WorkCuts::balance(const std::vector<double>& found) {
  const double whole = std::accumulate(found.begin(), found.end(), 0.0);
  const std::size_t ranks = found.size();
  // Work up to each cut, where all of it is 1.
  std::vector<double> sum{0};
  for (std::size_t r = 0; r < ranks; ++r) {
    const double width = static_cast<double>(begin_[r + 1] - begin_[r]) / whole_table;
    const double own =
        whole > 0 ? (found[r] / whole + asking_share * width) / (1 + asking_share) : width;
    sum.push_back(sum.back() + own);
  }
  const std::vector<std::uint32_t> before = begin_;
  std::size_t r = 0;
  for (std::size_t k = 1; k < ranks; ++k) {
    const double part = sum.back() * static_cast<double>(k) / static_cast<double>(ranks);
    while (r + 1 < ranks && sum[r + 1] < part) ++r;
    const double width = sum[r + 1] - sum[r];
    const double within = width > 0 ? std::clamp((part - sum[r]) / width, 0.0, 1.0) : 0.0;
    begin_[k] = before[r] + static_cast<std::uint32_t>(std::llround(
                                within * static_cast<double>(before[r + 1] - before[r])));
  }
}

}  // namespace weft
