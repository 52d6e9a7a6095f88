#include "host/app/run/energy_balance.hpp"

#include <algorithm>
#include <cmath>

#include "host/scene/frame_steps.hpp"
#include "host/scene/material_areas.hpp"

namespace weft::app {
namespace {

constexpr double gain_max = 0.01;
/// Small stiff cloth gains hundreds of times its energy where zones move it by less than the
/// thickness, and has lost it in the next step.
constexpr double explosion_factor = 1000;

double total(const Energy& e) {
  return e.kinetic + e.elastic + e.gravitational;
}

/// Motions stand still before their first and after their last key.
bool moves(const Motion& motion, double begin, double end) {
  return !motion.empty() && begin < motion.back().time && end > motion.front().time;
}

/// What contacts can give back: that which lifts all cloth by the thickness, and that which throws
/// it that far within a step, as their stiffness is made for the step.
/// @param step [s]
double stored_in_contacts(const Scene& scene, double step) {
  const std::vector<MaterialAreas> areas = areas_by_material(scene);
  double mass = 0;
  for (std::size_t m = 0; m < areas.size(); ++m) mass += areas[m].sum * scene.materials[m].density;
  const double thickness = scene.contact.thickness;
  const double speed = thickness / step;
  return mass * (length(scene.gravity) * thickness + speed * speed);
}

}  // namespace

EnergyBalance::EnergyBalance(const Scene& scene, const Energy& start)
    : scene_(&scene),
      // Energies of the asynchronous method are of positions and velocities at different times,
      // those of cloth out of view are its own.
      always_acts_(scene.method == "asynchronous" || scene.method == "view" ||
                   !scene.handles.empty() || scene.wind.density != 0 ||
                   std::any_of(scene.cloths.begin(), scene.cloths.end(),
                               [](const Cloth& c) { return c.pressure != 0; }) ||
                   std::any_of(scene.obstacles.begin(), scene.obstacles.end(),
                               [](const Obstacle& o) { return o.deformation != nullptr; })),
      stored_(stored_in_contacts(scene, longest_step(scene.time))) {
  restart(start, 0);
}

void EnergyBalance::restart(const Energy& now, double time) {
  frame_end_ = time;
  lowest_ = total(now);
  moving_ = now.kinetic + now.elastic;
  potential_low_ = potential_high_ = now.gravitational;
}

bool EnergyBalance::anything_acts(double begin, double end) const {
  return always_acts_ ||
         std::any_of(scene_->obstacles.begin(), scene_->obstacles.end(),
                     [&](const Obstacle& o) { return moves(o.motion, begin, end); }) ||
         std::any_of(scene_->pins.begin(), scene_->pins.end(),
                     [&](const Pin& p) { return moves(p.motion, begin, end); });
}

double EnergyBalance::at_play() const {
  return moving_ + potential_high_ - potential_low_;
}

double EnergyBalance::bound() const {
  return gain_max * at_play() + stored_;
}

void EnergyBalance::add(const StepReport& step, const std::optional<Energy>& energy) {
  acts_ = acts_ || step.compliance_distance > 0 || step.open_seam_pairs > 0 ||
          step.remesh.splits + step.remesh.flips + step.remesh.collapses > 0;
  if (scene_->time.automatic && step.step < shortest_step_) {
    shortest_step_ = step.step;
    stored_ = stored_in_contacts(*scene_, step.step);
  }
  if (!energy) return;
  acts_ = acts_ || anything_acts(frame_end_, step.time);
  const double now = total(*energy);
  const double before = at_play() + stored_;
  moving_ = std::max(moving_, energy->kinetic + energy->elastic);
  potential_low_ = std::min(potential_low_, energy->gravitational);
  potential_high_ = std::max(potential_high_, energy->gravitational);
  const double gain = now - lowest_;
  if (!acts_ && gain > bound() && gain > gain_) {
    gain_ = gain;
    gain_time_ = step.time;
  }
  exploded_ = !acts_ && gain - energy->elastic > explosion_factor * before;
  if (acts_ || now < lowest_) lowest_ = now;
  frame_end_ = step.time;
  acts_ = false;
}

}  // namespace weft::app
