#pragma once

#include <vector>

#include "host/implicit/linear/linear_system.hpp"
#include "host/implicit/parallel/row_balance.hpp"
#include "host/state/rank_geometry.hpp"
#include "host/state/store.hpp"
#include "weft/report.hpp"

namespace weft {

/// Which rows of the system each rank has. Results do not depend on it.
template <class T>
class RowSharing {
 public:
  RowSharing(Store<T>& store, std::vector<RankGeometry<T>>& geometry, LinearSystem<T>& system)
      : store_(store),
        geometry_(geometry),
        system_(system),
        balance_(store.scene().solver.rebalance, store.devices().backend()) {}

  /// Redistributes the rows, between two steps.
  /// @param row_begin as in Partition
  void share(std::vector<Index> row_begin);
  /// Redistributes the rows if the imbalance of earlier steps has cost enough.
  void rebalance(StepReport& report);
  /// Counts the cost of solves.
  /// @pre they have been waited for
  void count(int iterations, StepReport& report);

 private:
  Store<T>& store_;
  std::vector<RankGeometry<T>>& geometry_;
  LinearSystem<T>& system_;
  RowBalance balance_;
};

}  // namespace weft
