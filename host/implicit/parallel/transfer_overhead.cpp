#include "host/implicit/parallel/transfer_overhead.hpp"

#include <algorithm>
#include <cstddef>

namespace weft {
namespace {

/// S_i = next(S_{i-1}, sum of T_1 to T_i, C_i), from S_0 = C_0 on.
template <class Next>
std::vector<double> accumulate_times(const ProductTimes& times, Next next) {
  std::vector<double> done;
  double arrived = 0;
  for (std::size_t i = 0; i < times.compute.size(); ++i) {
    if (i == 0) {
      done.push_back(times.compute[0]);
      continue;
    }
    arrived += times.transfer[i - 1];
    done.push_back(next(done.back(), arrived, times.compute[i]));
  }
  return done;
}

}  // namespace

std::vector<double> gathered_times(const ProductTimes& times) {
  double computed = times.compute.empty() ? 0 : times.compute.front();
  return accumulate_times(times, [&](double, double arrived, double compute) {
    computed += compute;
    return arrived + computed;
  });
}

std::vector<double> pipelined_times(const ProductTimes& times) {
  return accumulate_times(times, [](double before, double arrived, double compute) {
    return std::max(before, arrived) + compute;
  });
}

}  // namespace weft
