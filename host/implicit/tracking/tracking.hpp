#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "host/model/model.hpp"
#include "weft/state/tracked_rows.hpp"

namespace weft {

/// Tracking constraints (Bergou et al. 2007) of a cloth whose averages follow another motion: sums
/// of positions, weighted by area and by test functions, are those of a target at the end of every
/// step. They fix averages, and leave what is finer free.
struct Tracking {
  std::vector<Offset> offset;     ///< [rows + 1] into the next two; a row is one test function
  std::vector<Index> input;       ///< of the scene's cloths, see input_offsets()
  std::vector<double> weight;     ///< [m^2] test function times area
  std::vector<double> free_from;  ///< [rows] [s] rows do not count before: their place is pinned
  /// Where the inputs would be at a time if there were nothing finer. [inputs] [m]
  std::function<std::vector<Vec3<double>>(double time)> target;
};

/// A row does not count where more than this share of its weights is on prescribed vertices.
constexpr double tracked_prescribed_max = 0.5;

/// Tracking as the solver takes it: rows in internal order, those that count, and their factors.
/// On the host only, for a single rank.
class TrackedSystem {
 public:
  /// @param tracking must outlive this, and so must `model`
  TrackedSystem(const Model& model, const Tracking& tracking);

  /// Sets the end of the step: which rows count, and what they come to.
  /// @param fixed [>= cloth vertices] see fixed_vertices()
  void aim(double time, const std::vector<unsigned char>& fixed);

  /// What the solution dv has to come to so that base + h (v + dv) has the sums that aim() wants.
  /// @param base [>= cloth vertices] [m]
  /// @param v    [cloth vertices] [m/s] iterate; empty: zero
  template <class T>
  TrackedRows rows(const std::vector<Vec3<T>>& base, const std::vector<Vec3<T>>& v, double h);

  /// By how much averages miss the target. [m]
  /// @param positions [>= cloth vertices] [m]
  template <class T>
  double error(const std::vector<Vec3<T>>& positions) const;

 private:
  void choose_rows(double time, const std::vector<unsigned char>& fixed);
  bool factorise();
  template <class T>
  Vec3<double> sum_of(std::size_t row, const std::vector<Vec3<T>>& x) const;

  const Model& model_;
  const Tracking& tracking_;
  std::vector<unsigned char> fixed_;   ///< as the rows were chosen
  std::vector<unsigned char> counts_;  ///< [rows of tracking_]
  std::vector<Offset> offset_;
  std::vector<Index> vertex_;
  std::vector<double> weight_, total_;
  std::vector<double> mass_inv_;
  std::vector<Index> order_, factor_row_;
  std::vector<Offset> column_;
  std::vector<double> factor_, pivot_;
  std::vector<Vec3<double>> aim_, wanted_, scratch_;
};

}  // namespace weft
