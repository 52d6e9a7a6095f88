#include "host/implicit/parallel/work_cuts.hpp"

#include <algorithm>
#include <cstddef>
#include <numeric>

namespace weft {
namespace {

constexpr std::size_t bins = 4096;
constexpr std::uint32_t bin_width = whole_table / bins;

/// No place is taken to come to less than this share of the mean: it may come to more later.
constexpr double least_expected = 1e-3;

}  // namespace

WorkCuts::WorkCuts(int ranks) : expected_(bins, 1.0) {
  for (std::size_t r = 0; r <= static_cast<std::size_t>(ranks); ++r)
    begin_.push_back(bins * r / static_cast<std::size_t>(ranks));
}

WorkShare WorkCuts::share(int rank) const {
  const auto r = static_cast<std::size_t>(rank);
  return {static_cast<std::uint32_t>(begin_[r]) * bin_width,
          static_cast<std::uint32_t>(begin_[r + 1]) * bin_width};
}

/// Scales what is expected of each share to what it came to. What earlier shares have told of
/// places within it stands.
void WorkCuts::learn(const std::vector<double>& came_to) {
  const double whole = std::accumulate(came_to.begin(), came_to.end(), 0.0);
  for (std::size_t r = 0; r < came_to.size(); ++r) {
    const auto first = expected_.begin() + static_cast<std::ptrdiff_t>(begin_[r]);
    const auto last = expected_.begin() + static_cast<std::ptrdiff_t>(begin_[r + 1]);
    const double sum = std::accumulate(first, last, 0.0);
    if (first == last) continue;
    const double scale = came_to[r] / whole * static_cast<double>(bins) / sum;
    std::for_each(first, last, [&](double& e) { e = std::max(least_expected, scale * e); });
  }
}

void WorkCuts::balance(const std::vector<double>& came_to) {
  if (std::accumulate(came_to.begin(), came_to.end(), 0.0) > 0)
    learn(came_to);
  else
    expected_.assign(bins, 1.0);
  const std::size_t ranks = came_to.size();
  const double whole = std::accumulate(expected_.begin(), expected_.end(), 0.0);
  double sum = 0;
  for (std::size_t b = 0, r = 1; r < ranks; ++r) {
    const double part = whole * static_cast<double>(r) / static_cast<double>(ranks);
    // The boundary of bins that is closest.
    while (b < bins && sum + expected_[b] / 2 < part) sum += expected_[b++];
    begin_[r] = b;
  }
}

}  // namespace weft
