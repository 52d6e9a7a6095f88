#pragma once

#include <limits>

#include "weft/report.hpp"

namespace weft {

/// Follows the window length that takes least work, by counts and not by clocks: it goes on in one
/// direction while that helps, and turns round where it does not.
class WindowTuner {
 public:
  /// @param window [s] to begin with
  explicit WindowTuner(double window) : window_(window) {}

  double window() const { return window_; }  ///< [s]

  /// @param counts of a time step @param length [s] of it
  void learn(const AsynchronousCounts& counts, double length) {
    const double work = work_of(counts) / length;
    if (work > work_before_) factor_ = 1 / factor_;
    work_before_ = work;
    const double next = window_ * factor_;
    if (next > length / 64 && next < length * 1.5)
      window_ = next;
    else
      factor_ = 1 / factor_;
  }

 private:
  /// In units of an element's force; the weights are what one of each took on one machine.
  static double work_of(const AsynchronousCounts& c) {
    const auto sum = [](std::int64_t n, double weight) { return static_cast<double>(n) * weight; };
    return sum(c.elements, 1) + sum(c.layer_pairs, 1) + sum(c.resimulated, 1) +
           sum(c.candidates, 5) + sum(c.slabs, 10) + sum(c.ccd_tests, 10) +
           sum(c.windows + c.rollbacks, 1000);
  }

  double window_;
  double factor_ = 1.189207115002721;  ///< fourth root of two
  double work_before_ = std::numeric_limits<double>::infinity();
};

}  // namespace weft
