#pragma once

namespace weft {

/// One try at a step, or at a part of one.
struct Attempt {
  double dt;             ///< [s]
  double h;              ///< [s] effective step of the integrator
  bool at_rest = false;  ///< x~ is x_n, so strain rates are 0 at the first iterate
  /// No shorter one will follow: zones may move as rigid bodies, and Newton's method may end in a
  /// linear solve. Switches off ContactMotionLimit, the tests of energy and strain limits, and the
  /// limits of unsolved rounds and of how far prescribed vertices give way at once.
  bool must_stand = false;
  bool may_solve_again = true;  ///< false: there is no system, and no test of the energy at its end
  bool whole = false;           ///< all of a step, and the first attempt at it
};

}  // namespace weft
