#include "host/implicit/parallel/work_queues.hpp"

#include <bit>
#include <cstddef>

namespace weft {

std::vector<std::vector<Transfer>> work_queues(int ranks) {
  const auto leaves = std::bit_ceil(static_cast<unsigned>(ranks));
  std::vector<std::vector<Transfer>> queues(leaves);
  // Switches from the lowest level up; `half` is the number of ranks on either side.
  for (unsigned half = 1; half < leaves; half *= 2)
    for (unsigned i = 0; i < leaves; ++i) {
      const bool left = (i & half) == 0;
      const int shift = left ? static_cast<int>(half) : -static_cast<int>(half);
      std::vector<Transfer>& queue = queues[i];
      const std::size_t below = queue.size();
      const int counterpart = static_cast<int>(i) + shift;
      queue.push_back({counterpart, counterpart});
      for (std::size_t n = 0; n < below; ++n)
        queue.push_back({queue[n].from, queue[n].vector + shift});
    }
  queues.resize(static_cast<std::size_t>(ranks));
  for (std::vector<Transfer>& queue : queues)
    for (Transfer& t : queue) {
      if (t.vector >= ranks)
        t = {};
      else if (t.from >= ranks)
        t.from = t.vector;
    }
  return queues;
}

std::vector<unsigned char> arrival_stages(const std::vector<Transfer>& queue, int rank, int ranks) {
  std::vector<unsigned char> stages(static_cast<std::size_t>(ranks));
  for (std::size_t n = 0; n < queue.size(); ++n)
    if (queue[n].any() && queue[n].vector != rank)
      stages[static_cast<std::size_t>(queue[n].vector)] = static_cast<unsigned char>(n + 1);
  return stages;
}

}  // namespace weft
