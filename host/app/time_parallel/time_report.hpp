#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "host/time_parallel/slices.hpp"

namespace weft::app {

/// What the outcome itself does not say.
struct TimeFacts {
  int workers = 1;
  const char* worker_kind = "thread";
  double largest_move = 0;     ///< [m] of a vertex from one frame to the next
  std::vector<int> blended{};  ///< [seams] frames over which a jump was spread out; empty: none
};

/// The part "time_parallel" of a report: partition, seams, recovery, and the speed-up that is to be
/// expected of such costs (Liang & Lin 2018, eq. 4, 6, 11, 16) beside the one that there was.
nlohmann::ordered_json time_report(const TimeParallelScene& scene, const SlicesOutcome& outcome,
                                   const TimeFacts& facts);

}  // namespace weft::app
