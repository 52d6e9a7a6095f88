#include "host/app/run/energy_balance.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "host/scene/contact_energy.hpp"
#include "host/scene/frame_steps.hpp"

namespace weft::app {
namespace {

constexpr double gain_max = 0.01;
/// Small stiff cloth gains hundreds of times its energy where zones move it by less than the
/// thickness, and has lost it in the next step.
constexpr double explosion_factor = 1000;
/// No everyday scene comes near this.
constexpr double sudden_factor = 1e5;
/// `needles` in steps of 0.02 s comes to 30.
constexpr double lasting_factor = 100;

}  // namespace

void EnergyBalance::Range::add(double value) {
  low = std::min(low, value);
  high = std::max(high, value);
}

EnergyBalance::EnergyBalance(const Scene& scene, const Energy& start)
    : scene_(&scene),
      // Energies of the asynchronous method are of positions and velocities at different times.
      known_(scene.method != "asynchronous"),
      dissipates_(scene.integrator != Integrator::bdf2),
      stored_(energy_of_contacts(scene, longest_step(scene.time))) {
  restart(start);
}

void EnergyBalance::restart(const Energy& now) {
  moving_ = now.kinetic + now.elastic;
  potential_ = {now.gravitational, now.gravitational};
  work_ = 0;
  work_range_ = {};
  unknown_ = suspect_ = fatal_ = false;
  lowest_ = now.total();
  elastic_at_lowest_ = now.elastic;
  quiet_ = moving_ + stored_;
}

double EnergyBalance::at_play() const {
  return moving_ + potential_.width() + work_range_.width();
}

double EnergyBalance::bound() const {
  return gain_max * at_play() + stored_;
}

std::string EnergyBalance::gain_text() const {
  return fmt::format(
      "cloth gained up to {:.4g} J from nothing, by {:.6g} s: {:.3g} % of the {:.4g} J at play",
      gain_, gain_time_, 100 * gain_ / gain_at_play_, gain_at_play_);
}

void EnergyBalance::add(const StepReport& step, const std::optional<Energy>& energy) {
  unknown_ = unknown_ || !known_ || !step.work;
  work_ += step.work.value_or(0);
  work_range_.add(work_);
  if (scene_->time.automatic && step.step < shortest_step_) {
    shortest_step_ = step.step;
    stored_ = energy_of_contacts(*scene_, step.step);
  }
  if (!energy) return;
  const double now = energy->total() - work_;
  const double before = at_play() + stored_;
  moving_ = std::max(moving_, energy->kinetic + energy->elastic);
  potential_.add(energy->gravitational);
  const double gain = now - lowest_;
  const double moving_gain = gain - std::max(0.0, energy->elastic - elastic_at_lowest_);
  // Energies before the gain, and the work.
  const double reference = quiet_ + potential_.width() + work_range_.width();
  const bool gains = !unknown_ && gain > bound();
  const bool suspect =
      gains ? (dissipates_ && moving_gain > bound()) || gain > lasting_factor * reference
            : unknown_ && known_ && gain > explosion_factor * reference;
  if ((gains || suspect) && gain > gain_) {
    gain_ = gain;
    gain_time_ = step.time;
    gain_at_play_ = at_play();
  }
  fatal_ = (suspect && suspect_) || (gains && moving_gain > explosion_factor * before) ||
           (gains && gain > sudden_factor * reference);
  suspect_ = suspect;
  if (!gains && !suspect) quiet_ = moving_ + stored_;
  if ((unknown_ && !suspect) || now < lowest_) {
    lowest_ = now;
    elastic_at_lowest_ = energy->elastic;
  }
  unknown_ = false;
}

}  // namespace weft::app
