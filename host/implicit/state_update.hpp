#pragma once

#include <vector>

#include "host/implicit/contact/contact_detection.hpp"
#include "host/implicit/step_error.hpp"
#include "host/state/rank_geometry.hpp"
#include "host/state/store.hpp"

namespace weft {

/// Turns the end of an accepted attempt into the state.
template <class T>
class StateUpdate {
 public:
  StateUpdate(Store<T>& store, const std::vector<RankGeometry<T>>& geometry,
              std::vector<RankMotion<T>>& motion, const ContactDetection<T>& detection);

  /// No part of the step has been accepted yet.
  void begin_step() { step_error_ = 0; }

  /// Fills the contact cache for the next step.
  /// @param dt [s] length of the attempt
  void cache_contacts(double dt);
  /// Records which vertices zones have moved.
  /// @param hardening which contacts of those moved in this attempt harden
  void remember_touched(Hardening hardening);
  /// The end of an attempt of length dt [s] becomes the state.
  void accept(double dt);

  /// Sum over the accepted parts of the step, see StepError; 0 with fixed steps.
  double step_error() const noexcept { return step_error_; }

 private:
  Store<T>& store_;
  const std::vector<RankGeometry<T>>& geometry_;
  std::vector<RankMotion<T>>& motion_;
  const ContactDetection<T>& detection_;
  StepError<T> error_estimate_;
  double step_error_ = 0;
};

}  // namespace weft
