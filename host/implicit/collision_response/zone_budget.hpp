#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>

namespace weft {

/// Budget of impact zones for a step, in visits to collisions. It is counted, not timed, so results
/// do not depend on the machine.
class ZoneBudget {
 public:
  /// Budget of a whole step.
  static std::int64_t of_step(std::int64_t vertices) {
    return visits_per_vertex * std::max(vertices_least, vertices);
  }
  /// Budget of an attempt that will probably fail, and of a solve in a truncated step.
  static std::int64_t of_part(std::int64_t vertices) { return of_step(vertices) / part_share; }

  void grant(std::int64_t visits) { left_ = granted_ = visits; }
  /// Sets most of the rest aside for the two halves of the attempt, in case it fails.
  void reserve() {
    reserved_ = left_ - left_ / attempt_share;
    left_ -= reserved_;
  }
  void release() { left_ += std::exchange(reserved_, 0); }
  void spend(std::int64_t visits) { left_ -= visits; }

  std::int64_t left() const noexcept { return left_; }
  std::int64_t reserved() const noexcept { return reserved_; }
  std::int64_t granted() const noexcept { return granted_; }

 private:
  /// Such a visit costs a quarter of a row of the matrix in a product, and an ordinary step takes
  /// some hundred products: so zones get some 15 times as much as the rest of a step.
  static constexpr std::int64_t visits_per_vertex = 6'000;
  /// Cloths of fewer vertices get as much as one of so many.
  static constexpr std::int64_t vertices_least = 256;
  static constexpr std::int64_t part_share = 8;
  /// Attempts that may be bisected get one part in so many of the rest.
  static constexpr std::int64_t attempt_share = 4;

  std::int64_t left_ = 0, reserved_ = 0, granted_ = 0;
};

}  // namespace weft
