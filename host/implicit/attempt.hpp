#pragma once

namespace weft {

/// One try at a step, or at a part of one.
struct Attempt {
  double dt;             ///< [s]
  double h;              ///< [s] effective step of the integrator
  bool at_rest = false;  ///< x~ is x_n, so strain rates are 0 at the first iterate
  /// No shorter one will follow: zones may move as rigid bodies, and what a shorter step would
  /// avoid is accepted.
  bool last_resort = false;
  bool solved = true;  ///< there is a system, which may be solved again
  bool whole = false;  ///< all of a step, and the first attempt at it
};

}  // namespace weft
