#pragma once

#include <utility>
#include <vector>

#include "weft/exec/device.hpp"
#include "weft/kernels/collide/pairs.hpp"
#include "weft/report.hpp"

namespace weft {

/// Counts what each rank does of pair searches and of all that goes over their lists: for reports,
/// and for WorkCuts. Does nothing with a single rank.
class SearchBalance {
 public:
  SearchBalance(int ranks, Backend backend);

  /// Ranks have asked for their shares of the pairs.
  void add_search(const std::vector<CollideCounts>& counts);
  /// Ranks have gone over their lists for contacts.
  void add_pass(const std::vector<CollideCounts>& counts);
  /// Ranks have gone over their lists for collisions.
  void add_detection(const std::vector<CollideCounts>& counts);

  /// Work of each rank since the last call: pairs that it looked at, or what takes as long. [ranks]
  std::vector<double> take_work();
  /// How evenly the ranks were busy since the last call.
  BalanceReport take_report() { return std::exchange(report_, {}); }

 private:
  double test_price_;         ///< of a box test, in pairs
  std::vector<double> work_;  ///< [ranks]
  BalanceReport report_;
};

}  // namespace weft
