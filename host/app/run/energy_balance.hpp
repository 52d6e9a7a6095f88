#pragma once

#include <limits>
#include <optional>
#include <string>

#include "weft/report.hpp"
#include "weft/scene.hpp"

namespace weft::app {

/// How much energy cloth gains that nothing gives it. The energy of an integrator that dissipates,
/// less the work of what acts on the cloth, can only fall: if at the end of a frame it exceeds the
/// lowest since then by more than 1 % of what is at play, something is wrong, whatever it is. At
/// play is the largest kinetic and elastic energy of the run so far, what gravity has done, and the
/// work of bodies, pins, handles, seams, wind and pressure. Where that is not known the balance
/// begins again. Contacts also store energy; the most that they can release is added to the bound.
///
/// A gain that lasts from one frame to the next is fatal: one of kinetic and potential energy
/// beyond the bound, or one with elastic energy of a hundred times the energies before the gain and
/// the work, that of gravity as well (with BDF2, whose energy may swing, only the second); of a
/// thousand times where not all work is known. Impact zones know nothing of elasticity. Where they
/// hold back cloth, steps may end with it stretched, by several times the energy at play in
/// everyday scenes. Later solves dissipate that. A sudden gain of kinetic and potential energy of a
/// thousand times what was at play is fatal at once, and so is one with elastic energy of a hundred
/// thousand times.
class EnergyBalance {
 public:
  /// @param start energy of the state that the run begins with
  EnergyBalance(const Scene& scene, const Energy& start);

  /// Takes the next step.
  /// @param energy at its end, if that is the end of a frame
  void add(const StepReport& step, const std::optional<Energy>& energy);

  /// Starts again from a state of a changed scene, or of a run whose earlier steps are unknown.
  void restart(const Energy& now);

  bool fatal() const { return fatal_; }
  /// Whether the latest frame's gain is fatal if it lasts.
  bool suspect() const { return suspect_; }
  /// [J] largest gain so far of those that exceed the bound; 0: none
  double gain() const { return gain_; }
  /// [s] end of its frame
  double gain_time() const { return gain_time_; }
  /// [J] energy at play by then
  double gain_at_play() const { return gain_at_play_; }
  /// How large the largest gain was.
  std::string gain_text() const;
  /// [J] that a gain may come to now
  double bound() const;

 private:
  double at_play() const;

  /// Least and largest of a sum so far. [J]
  struct Range {
    double low = 0, high = 0;
    void add(double value);
    double width() const { return high - low; }
  };

  const Scene* scene_;  ///< must outlive this
  bool known_;          ///< the method's energies can be compared
  bool dissipates_;     ///< the integrator, in each step and in this energy
  double stored_;       ///< [J] what contacts can release
  double shortest_step_ = std::numeric_limits<double>::infinity();  ///< [s] of automatic ones
  double moving_ = 0;  ///< [J] largest kinetic and elastic energy
  Range potential_;    ///< of gravity
  double work_ = 0;    ///< [J] since the start
  Range work_range_;
  bool unknown_ = false;          ///< some work since the last frame is not known
  double lowest_ = 0;             ///< [J] energy less work
  double elastic_at_lowest_ = 0;  ///< [J]
  double quiet_ = 0;              ///< [J] moving_ and stored_ in the latest frame without a gain
  double gain_ = 0, gain_time_ = 0, gain_at_play_ = 0;
  bool suspect_ = false, fatal_ = false;
};

}  // namespace weft::app
