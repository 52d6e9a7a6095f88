#include "host/time_parallel/schedule.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "weft/core/assert.hpp"

namespace weft {
namespace {

/// (1 - q^j) / (1 - q^p) with q = 1 - 1 / ratio, which is j / p at infinity.
double balanced_share(int j, int slices, double ratio) {
  if (!(ratio < std::numeric_limits<double>::infinity()))
    return static_cast<double>(j) / static_cast<double>(slices);
  // By expm1, which stays exact where the ratio is large.
  const double log_q = std::log1p(-1 / ratio);
  return std::expm1(j * log_q) / std::expm1(slices * log_q);
}

/// Moves starts apart, so that each slice has a step.
void leave_a_step_each(std::vector<std::int64_t>& starts, std::int64_t steps) {
  const auto count = static_cast<std::int64_t>(starts.size());
  for (std::int64_t j = 1; j < count; ++j) {
    auto& start = starts[static_cast<std::size_t>(j)];
    start = std::max(start, starts[static_cast<std::size_t>(j - 1)] + 1);
    start = std::min(start, steps - (count - j));
  }
}

}  // namespace

std::vector<std::int64_t> uniform_starts(std::int64_t steps, int slices) {
  WEFT_ASSERT(slices >= 1 && slices <= steps);
  std::vector<std::int64_t> starts;
  for (std::int64_t j = 0; j < slices; ++j) starts.push_back(steps * j / slices);
  return starts;
}

std::vector<std::int64_t> balanced_starts(std::int64_t steps, int slices, double ratio) {
  WEFT_ASSERT(slices >= 1 && slices <= steps && ratio > 1);
  std::vector<std::int64_t> starts;
  for (int j = 0; j < slices; ++j)
    starts.push_back(static_cast<std::int64_t>(
        std::floor(balanced_share(j, slices, ratio) * static_cast<double>(steps))));
  leave_a_step_each(starts, steps);
  return starts;
}

double uniform_speedup(double ratio, int slices) {
  return ratio * slices / (ratio + slices - 1);
}

double balanced_speedup(double ratio, int slices) {
  return -ratio * std::expm1(slices * std::log1p(-1 / ratio));
}

double least_speedup(double ratio, int slices) {
  return ratio * slices / (ratio + slices);
}

double speedup_with_recovery(std::int64_t steps, double recovery, double speedup) {
  const auto n = static_cast<double>(steps);
  return n / (recovery + n / speedup);
}

double adaptive_cut(std::int64_t steps, int slices, double ratio) {
  const auto n = static_cast<double>(steps);
  if (slices == 1) return n;
  const double last = balanced_share(slices - 1, slices, ratio) * n;
  if (!(ratio < std::numeric_limits<double>::infinity())) return n - last;
  return n / ratio + (ratio - 1) / ratio * (n - last);
}

SliceDone SliceDone::within(const std::vector<double>& work, double most) {
  const auto after = std::upper_bound(work.begin(), work.end(), most);
  if (after == work.begin()) return {};
  return {after - work.begin() - 1, *(after - 1)};
}

AdaptiveCuts::AdaptiveCuts(std::int64_t steps, int slices) : steps_(steps), slices_(slices) {
  WEFT_ASSERT(slices >= 1 && slices <= steps);
}

void AdaptiveCuts::advance_coarse(std::int64_t step, double work) {
  WEFT_ASSERT(step > coarse_steps_.back() && work >= coarse_work_.back());
  coarse_steps_.push_back(step);
  coarse_work_.push_back(work);
}

/// Linear in between, as the coarse run's steps are longer.
double AdaptiveCuts::coarse_work(std::int64_t step) const {
  const auto place = std::lower_bound(coarse_steps_.begin(), coarse_steps_.end(), step);
  if (place == coarse_steps_.end()) return coarse_work_.back();
  const auto i = static_cast<std::size_t>(place - coarse_steps_.begin());
  if (coarse_steps_[i] == step) return coarse_work_[i];
  const double share = static_cast<double>(step - coarse_steps_[i - 1]) /
                       static_cast<double>(coarse_steps_[i] - coarse_steps_[i - 1]);
  return coarse_work_[i - 1] + share * (coarse_work_[i] - coarse_work_[i - 1]);
}

double AdaptiveCuts::work_wanted(int slice) const {
  return coarse_work_.back() - coarse_work(starts_[static_cast<std::size_t>(slice)]) - delay_;
}

/// Eq. (7), in the latest slices; infinity: not known.
double AdaptiveCuts::ratio(const std::function<SliceDone(int, double)>& done) const {
  std::int64_t steps = 0;
  double fine = 0, coarse = 0;
  for (int j = slice(); j >= 0 && steps < known_steps; --j) {
    const SliceDone d = done(j, work_wanted(j));
    if (d.steps < 1) continue;
    const std::int64_t start = starts_[static_cast<std::size_t>(j)];
    steps += d.steps;
    fine += d.work;
    coarse += coarse_work(start + d.steps) - coarse_work(start);
  }
  if (steps < known_steps) return std::numeric_limits<double>::infinity();
  return std::max(1 + 1e-9, fine / coarse);
}

bool AdaptiveCuts::decide(const std::function<SliceDone(int, double)>& done) {
  if (complete()) return false;
  const std::int64_t start = starts_.back();
  const int slices = slices_ - slice();
  const auto left = static_cast<double>(steps_ - start);
  const double cut = std::min(adaptive_cut(steps_ - start, slices, ratio(done)),
                              length_max * left / static_cast<double>(slices));
  // Each slice after this one needs a step, and the coarse run has to be there.
  const std::int64_t most = steps_ - start - (slices - 1);
  auto length = static_cast<std::int64_t>(std::ceil(std::min(cut, static_cast<double>(most))));
  // Whoever simulates the slice may be where the coarse run was before.
  const std::int64_t passed =
      coarse_steps_.size() > 1 ? coarse_steps_[coarse_steps_.size() - 2] : 0;
  length = std::max<std::int64_t>({length, passed - start, 1});
  if (start + length > coarse_steps_.back()) return false;
  starts_.push_back(start + std::min(length, most));
  return true;
}

double schedule_length(const ScheduleCosts& costs, const std::vector<std::int64_t>& starts) {
  const auto at = [](const std::vector<double>& v, std::int64_t i) {
    return v[static_cast<std::size_t>(i)];
  };
  const auto steps = static_cast<std::int64_t>(costs.fine.size()) - 1;
  double end = 0;
  for (std::size_t j = 0; j < starts.size(); ++j) {
    const std::int64_t last = j + 1 < starts.size() ? starts[j + 1] : steps;
    const double recovery = j > 0 ? costs.recovery : 0;
    end = std::max(end, at(costs.coarse, starts[j]) + recovery + at(costs.fine, last) -
                            at(costs.fine, starts[j]));
  }
  return end;
}

std::vector<std::int64_t> adaptive_starts(const ScheduleCosts& costs, int slices) {
  const auto steps = static_cast<std::int64_t>(costs.fine.size()) - 1;
  AdaptiveCuts cuts(steps, slices);
  cuts.set_delay(0);
  for (std::int64_t n = 1; n <= steps && !cuts.complete(); ++n) {
    cuts.advance_coarse(n, costs.coarse[static_cast<std::size_t>(n)]);
    const auto done = [&](int slice, double wanted) -> SliceDone {
      const auto& starts = cuts.starts();
      const auto j = static_cast<std::size_t>(slice);
      const double recovery = slice > 0 ? costs.recovery : 0;
      const auto first = costs.fine.begin() + starts[j];
      const auto end = costs.fine.begin() + (j + 1 < starts.size() ? starts[j + 1] : n) + 1;
      const auto after = std::upper_bound(first, end, *first + wanted - recovery);
      if (after == first) return {};
      return {after - first - 1, *(after - 1) - *first + recovery};
    };
    while (cuts.decide(done)) {
    }
  }
  return cuts.starts();
}

}  // namespace weft
