#pragma once

#include <vector>

#include "host/implicit/contact/contact_detection.hpp"
#include "host/state/store.hpp"

namespace weft {

/// How far contacts may move in an attempt. They are linearised: a longer motion leaves the planes
/// and triangles on which they were found.
template <class T>
class ContactMotionLimit {
 public:
  ContactMotionLimit(Store<T>& store, const ContactDetection<T>& detection)
      : store_(store), detection_(detection) {}

  /// Forgets how fast contacts moved in the step before.
  void begin_step() { turning_acceleration_ = slide_speed_ = 0; }

  /// Measures the contacts that have been found for an attempt.
  /// @param dt     [s] its length
  /// @param placed [obstacle vertices] [m] at its end
  void measure(double dt, const std::vector<Vec3<double>>& placed);

  /// Whether, in a time dt [s], obstacles would leave the planes of their contacts too far, or
  /// contacts with a large load would slide past too many triangles.
  bool exceeded_in(double dt) const;

 private:
  void measure_turning(double dt, const std::vector<Vec3<double>>& placed);

  Store<T>& store_;
  const ContactDetection<T>& detection_;
  std::vector<Vec3<double>> placed_before_;  ///< at the start of the attempt, if any rotates
  /// [m/s^2] at which rotating obstacles leave the planes of contacts, at most, in this step
  double turning_acceleration_ = 0;
  double slide_speed_ = 0;  ///< [edges/s] see ContactDetection::slide()
};

}  // namespace weft
