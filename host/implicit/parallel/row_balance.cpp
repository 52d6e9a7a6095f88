#include "host/implicit/parallel/row_balance.hpp"

#include <algorithm>
#include <cstddef>
#include <numeric>

#include "host/implicit/parallel/shared_work.hpp"

namespace weft {
namespace {

/// What rebuilding the ranks' parts of the matrix takes, in iterations. A core makes a row in 1
/// us, whatever it is for; an iteration takes some 85 ns of it for a row, and 0.24 ns of a GPU.
/// The rest is for memory and copies.
constexpr double price_on_host = 25;
constexpr double price_on_gpus = 5000;
/// Share of what exceeds an even share that a cut has to save.
constexpr double saving_share = 0.5;
/// Cuts that differ by less of an even share are as good as each other.
constexpr double worth_share = 0.005;

/// Whether ranks can take all of `work` in order with at most `bound` each.
/// @param begin receives the first partial of each rank; [ranks + 1]
bool fits(const std::vector<double>& work, double bound, std::vector<std::size_t>& begin) {
  const std::size_t ranks = begin.size() - 1;
  std::size_t next = 0;
  for (std::size_t r = 0; r < ranks; ++r) {
    begin[r] = next;
    double sum = 0;
    while (next < work.size() && sum + work[next] <= bound) sum += work[next++];
  }
  begin[ranks] = work.size();
  return next == work.size();
}

/// [ranks]
std::vector<double> sums_of(const std::vector<double>& work,
                            const std::vector<std::size_t>& begin) {
  std::vector<double> sums;
  for (std::size_t r = 0; r + 1 < begin.size(); ++r)
    sums.push_back(std::accumulate(work.begin() + static_cast<std::ptrdiff_t>(begin[r]),
                                   work.begin() + static_cast<std::ptrdiff_t>(begin[r + 1]), 0.0));
  return sums;
}

}  // namespace

std::vector<std::size_t> even_ranges(const std::vector<double>& work, int ranks) {
  std::vector<std::size_t> begin(static_cast<std::size_t>(ranks) + 1);
  const double whole = std::accumulate(work.begin(), work.end(), 0.0);
  const double most = work.empty() ? 0 : *std::max_element(work.begin(), work.end());
  // A rank that is closed has left out a partial: with this bound all is taken.
  double high = whole / ranks + most;
  double low = std::max(whole / ranks, most);
  high += 1e-9 * high;  // sums are rounded
  while (high - low > 1e-6 * high) {
    const double middle = low + (high - low) / 2;
    (fits(work, middle, begin) ? high : low) = middle;
  }
  fits(work, high, begin);
  return begin;
}

void RowBalance::add(const Work& work, int iterations) {
  const SharedWork shared = shared_work(work);
  even_ = shared.even;
  lost_ += iterations * std::max(0.0, shared.busiest - reachable_ * shared.even);
}

bool RowBalance::due() const noexcept {
  if (when_ == Rebalance::never || even_ <= 0) return false;
  const double price = backend_ == Backend::host ? price_on_host : price_on_gpus;
  return when_ == Rebalance::every_step || lost_ >= price * even_;
}

std::optional<RowBalance::Cut> RowBalance::cut(const Work& work, const Partition& partition) {
  std::vector<std::size_t> now;
  for (const Index row : partition.row_begin)
    now.push_back(
        (static_cast<std::size_t>(row) + static_cast<std::size_t>(partition.partial_rows) - 1) /
        static_cast<std::size_t>(partition.partial_rows));
  const std::vector<std::size_t> best = even_ranges(work, partition.ranks());
  const SharedWork before = shared_work(sums_of(work, now));
  const SharedWork after = shared_work(sums_of(work, best));
  lost_ = 0;
  reachable_ = after.imbalance();
  const double saving = before.busiest - after.busiest;
  const bool worth =
      saving > worth_share * before.even && saving >= saving_share * (before.busiest - before.even);
  if (best == now || (when_ != Rebalance::every_step && !worth)) return std::nullopt;
  Cut cut{{}, before.imbalance(), after.imbalance()};
  for (const std::size_t partial : best)
    cut.row_begin.push_back(static_cast<Index>(std::min(
        Offset{partition.row_count()}, static_cast<Offset>(partial) * partition.partial_rows)));
  return cut;
}

}  // namespace weft
