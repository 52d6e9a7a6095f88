#pragma once

#include <optional>
#include <vector>

#include "host/state/partition.hpp"
#include "weft/exec/device.hpp"
#include "weft/report.hpp"
#include "weft/scene.hpp"

namespace weft {

/// Decides from counted work when ranks get other rows. Each solve costs what its busiest rank has
/// beyond an even share, and redistributing rows has a price: it is paid once as much has been
/// lost, so that no course of a run costs more than twice what the best one would have. Nothing is
/// timed, and which rows a rank has changes no bits.
class RowBalance {
 public:
  /// Work by rank, or by partial sum of a dot product. [bytes] an iteration reads and writes
  using Work = std::vector<double>;

  /// Rows of the ranks from now on, and how evenly they share the work.
  struct Cut {
    std::vector<Index> row_begin;  ///< [ranks + 1] as in Partition
    double imbalance_before = 1;   ///< busiest rank over the mean
    double imbalance_after = 1;
  };

  RowBalance(Rebalance when, Backend backend) : when_(when), backend_(backend) {}

  /// Solves have been made.
  /// @param work [ranks]
  void add(const Work& work, int iterations);

  /// Whether to count what each reduction block's rows are worth, and ask for a cut by it.
  bool due() const noexcept;

  /// The best cut by counts, if it is worth its price.
  /// @param work      [partials of `partition`]
  /// @param partition as the rows are shared out now
  std::optional<Cut> cut(const Work& work, const Partition& partition);

 private:
  Rebalance when_;
  Backend backend_;
  double lost_ = 0;       ///< [bytes] since the last look
  double even_ = 0;       ///< [bytes] an iteration, on average over the ranks
  double reachable_ = 1;  ///< imbalance that the last look could not avoid
};

/// First partial of each rank, and behind the last one their number, such that the busiest rank has
/// as little as it can with ranges of partials. [ranks + 1]
/// @param work [partials], >= 0
std::vector<std::size_t> even_ranges(const std::vector<double>& work, int ranks);

}  // namespace weft
