#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/app/run/energy_balance.hpp"
#include "host/app/run/run_report.hpp"

namespace weft::app {

void RunTotals::Automatic::add(const StepReport& r) {
  if (!r.step_error) return;
  shortest = steps > 0 ? std::min(shortest, r.step) : r.step;
  longest = std::max(longest, r.step);
  error_max = std::max(error_max, *r.step_error);
  rejected += r.rejected;
  ++steps;
}

RunTotals::RunTotals(const Energy& start) : start_(start.total()), largest_(std::abs(start_)) {}

void RunTotals::add(const StepLine& line) {
  const StepReport& r = line.report;
  ++steps;
  wall += line.wall;
  stages += r.stages;
  solves += r.solves;
  iterations += r.iterations;
  iterations_max = std::max(iterations_max, r.iterations_max);
  // A residual that is not a number is the worst of all.
  if (std::isnan(r.residual_max) || r.residual_max > residual_max) residual_max = r.residual_max;
  proximities_max = std::max(proximities_max, r.proximities);
  impacts += r.impacts;
  (r.self_certified ? with_certificate : without_certificate).add(r);
  zones_max = std::max(zones_max, r.zones);
  zone_rounds_max = std::max(zone_rounds_max, r.zone_rounds);
  zone_largest = std::max(zone_largest, r.zone_largest);
  zone_passes += r.zone_passes;
  zones_unsolved += r.zones_unsolved;
  plane_zones += r.plane_zones;
  rigid_zones += r.rigid_zones;
  truncations += r.truncations;
  compliance_distance_max = std::max(compliance_distance_max, r.compliance_distance);
  if (r.limit_excess) limit_excess = std::max(limit_excess.value_or(0), *r.limit_excess);
  ++steps_at_fallback_level[static_cast<std::size_t>(r.fallback_level)];
  retries += r.retries;
  asynchronous += r.asynchronous;
  add_remesh(r.remesh);
  add_sleep(r.sleep);
  automatic.add(r);
  balance += r.balance;
  if (line.energy) kinetic_max = std::max(kinetic_max, line.energy->kinetic);
  if (line.energy) largest_ = std::max(largest_, std::abs(line.energy->total()));
}

std::string RunTotals::exceeded_limits() const {
  if (!(limit_excess.value_or(0) > limit_excess_max)) return "";
  return fmt::format("cloth exceeded a strain limit by up to {:.3g} % of it", 100 * *limit_excess);
}

void RunTotals::add_remesh(const RemeshReport& r) {
  if (r.triangles == 0) return;
  ++remeshes;
  remesh.splits += r.splits;
  remesh.flips += r.flips;
  remesh.collapses += r.collapses;
  remesh.refused += r.refused;
  remesh.redone += r.redone;
  remesh.vertices = std::max(remesh.vertices, r.vertices);
  remesh.triangles = std::max(remesh.triangles, r.triangles);
  remesh.energy_jump = std::max(remesh.energy_jump, std::abs(r.energy_jump));
  remesh.seconds += r.seconds;
  remesh.rebuild_seconds += r.rebuild_seconds;
  remesh.cpu_seconds += r.cpu_seconds;
}

void RunTotals::add_sleep(const SleepReport& r) {
  sleep.pieces = std::max(sleep.pieces, r.pieces);
  sleep.asleep += r.asleep;
  sleep.fell_asleep += r.fell_asleep;
  sleep.woken += r.woken;
  sleep.redone += r.redone;
  sleep.departure = std::max(sleep.departure, r.departure);
}

std::optional<double> RunTotals::drift(const Energy& now) const {
  const double largest = std::max(largest_, std::abs(now.total()));
  if (!(largest > 0)) return std::nullopt;
  return (now.total() - start_) / largest;
}

}  // namespace weft::app
