#pragma once

#include <limits>
#include <optional>

#include "weft/report.hpp"
#include "weft/scene.hpp"

namespace weft::app {

/// How much energy cloth gains that nothing gives it. While only gravity does work, the energy of
/// an integrator that dissipates can only fall: if at the end of a frame it exceeds the lowest
/// since then by more than 1 % of what is at play, something is wrong, whatever it is. At play is
/// the largest kinetic and elastic energy of the run so far, and what gravity has done. Nothing is
/// known of frames in which bodies or pins move or give way, seams are open, or wind, pressure or
/// handles act. Contacts also store energy; the most that they can release is added to the bound.
class EnergyBalance {
 public:
  /// @param start energy of the state that the run begins with
  EnergyBalance(const Scene& scene, const Energy& start);

  /// Takes the next step.
  /// @param energy at its end, if that is the end of a frame
  void add(const StepReport& step, const std::optional<Energy>& energy);

  /// Starts again from a state of a changed scene, or of a run whose earlier steps are unknown.
  /// @param time [s] of that state
  void restart(const Energy& now, double time);

  /// Whether the latest frame has gained a thousand times what was at play before, elastic energy
  /// left out: it has exploded.
  bool exploded() const { return exploded_; }
  /// [J] largest gain so far of those that exceed the bound; 0: none
  double gain() const { return gain_; }
  /// [s] end of its frame
  double gain_time() const { return gain_time_; }
  /// [J] that a gain may come to now
  double bound() const;

 private:
  bool anything_acts(double begin, double end) const;
  double at_play() const;

  const Scene* scene_;
  bool always_acts_;
  double stored_;  ///< [J] what contacts can release
  double shortest_step_ = std::numeric_limits<double>::infinity();  ///< [s] of automatic ones
  double lowest_ = 0, moving_ = 0, potential_low_ = 0, potential_high_ = 0;  ///< [J]
  double frame_end_ = 0;                                                     ///< [s]
  bool acts_ = false;  ///< in a step since the last frame
  double gain_ = 0, gain_time_ = 0;
  bool exploded_ = false;
};

}  // namespace weft::app
