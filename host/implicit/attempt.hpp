#pragma once

namespace weft {

/// One try at a step, or at a part of one.
struct Attempt {
  double dt;                 ///< [s]
  double h;                  ///< [s] effective step of the integrator
  bool at_rest = false;      ///< x~ is x_n, so strain rates are 0 at the first iterate
  bool last_resort = false;  ///< the shortest substep: zones may move as rigid bodies
  bool solved = true;        ///< its end is the solution of a system that may be solved again
  bool whole = false;        ///< all of a step, and the first attempt at it
};

}  // namespace weft
