#include "host/implicit/parallel/search_balance.hpp"

#include "host/implicit/parallel/shared_work.hpp"

namespace weft {
namespace {

// What a box test takes, in pairs that a narrow phase passes over. Host: 6 ns, with all that a
// search does beside it (benchmarks/results/latest/2x-amd-epyc/broad.json), over a pass that is
// taken to be 100. GPUs: 1040 us for 19 tests a pair, where a pass takes 134
// (benchmarks/results/latest/1x-nvidia-h100).
constexpr double test_price_on_host = 0.06;
constexpr double test_price_on_gpus = 0.4;
/// The same of a pair that the cheap test of continuous detection cannot decide. Host: 385 ns
/// (benchmarks/results/latest/2x-amd-epyc/ccd.json); of GPUs not known.
constexpr double ccd_price = 4;

/// @param number of a rank's counts
template <class Number>
std::vector<double> of_ranks(const std::vector<CollideCounts>& counts, Number number) {
  std::vector<double> numbers;
  for (const CollideCounts& c : counts) numbers.push_back(static_cast<double>(number(c)));
  return numbers;
}

/// Books a piece of work that takes `price` an item.
void book(const std::vector<double>& items, double price, SharedWork& report,
          std::vector<double>& work) {
  if (items.size() == 1) return;
  report += shared_work(items);
  for (std::size_t r = 0; r < items.size(); ++r) work[r] += price * items[r];
}

}  // namespace

SearchBalance::SearchBalance(int ranks, Backend backend)
    : test_price_(backend == Backend::host ? test_price_on_host : test_price_on_gpus),
      work_(static_cast<std::size_t>(ranks), 0) {}

void SearchBalance::add_search(const std::vector<CollideCounts>& counts) {
  book(of_ranks(counts, [](const CollideCounts& c) { return c.tests; }), test_price_,
       report_.box_tests, work_);
}

void SearchBalance::add_pass(const std::vector<CollideCounts>& counts) {
  book(of_ranks(counts, [](const CollideCounts& c) { return Offset{c.face_pairs} + c.edge_pairs; }),
       1, report_.pairs, work_);
}

void SearchBalance::add_detection(const std::vector<CollideCounts>& counts) {
  add_pass(counts);
  book(of_ranks(counts, [](const CollideCounts& c) { return c.ccd_tests; }), ccd_price,
       report_.ccd_tests, work_);
}

std::vector<double> SearchBalance::take_work() {
  report_.queries += shared_work(work_);
  return std::exchange(work_, std::vector<double>(work_.size(), 0));
}

}  // namespace weft
