#include "host/simulation/remesh_step.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "host/exec/cpu_seconds.hpp"
#include "host/simulation/compression.hpp"
#include "host/simulation/state_energy.hpp"

namespace weft {
namespace {

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void add_counts(const RemeshCounts& counts, RemeshReport& report) {
  report.splits = counts.splits;
  report.flips = counts.flips;
  report.collapses = counts.collapses;
  report.refused += counts.refused;
}

/// A run on the meshes that a remesh has given the scene.
/// @return null if that changes the energy too much
template <class T>
std::unique_ptr<Run<T>> run_after(const SceneRemesh& done, const Scene& scene, const Sewing& sewing,
                                  const AdaptiveRun& adaptive, DeviceSet& devices,
                                  const Run<T>& current, const Energy& before,
                                  RemeshReport& report) {
  const auto rebuild = std::chrono::steady_clock::now();
  auto next = std::make_unique<Run<T>>(scene, devices, sewing, &current);
  const Model& from = current.store.model();
  const StateSnapshot<T> state = current.store.snapshot();
  StateSnapshot<T> now = remeshed_state(from, state, done, next->store.model());
  next->store.restore(now);
  report.rebuild_seconds += seconds_since(rebuild);
  const Energy after = energy_of(next->store);
  double jump = surface_kinetic(scene, next->store.model(), now.velocities) -
                surface_kinetic(scene, from, state.velocities) + (after.elastic - before.elastic) +
                (after.gravitational - before.gravitational);
  if (jump > 0) {
    jump -= pay_from_motion(scene, next->store.model(), done, jump, now);
    next->store.restore(now);
  }
  if (!(std::abs(jump) <= largest_jump(scene, from, adaptive, state.step_number))) return nullptr;
  report.energy_jump = jump;
  return next;
}

}  // namespace

template <class T>
RemeshReport remesh_step(Scene& scene, const Sewing& sewing, AdaptiveRun& adaptive,
                         DeviceSet& devices, std::unique_ptr<Run<T>>& run) {
  const auto start = std::chrono::steady_clock::now();
  const double cpu_start = cpu_seconds();
  RemeshReport report;
  const bool view = scene.method == "view";
  const double seen_before = view ? energy_of(run->store).elastic : 0;
  // That of the material itself: how it yields out of view is decided each time.
  run->store.set_compression({});
  const Energy before = energy_of(run->store);
  // What a cloth is thrown with may be gone after a frame, and would be much to add to what is
  // left.
  if (run->store.step_number > 0)
    adaptive.peak_kinetic = std::max(adaptive.peak_kinetic, before.kinetic);
  for (int tries = 0; tries < 2; ++tries) {
    SceneRemesh done = remesh_run(scene, sewing.welded, adaptive, run->store, tries);
    add_counts(done.counts, report);
    if (!done.changed()) break;
    // A run refers to its scene, which stays where it is.
    std::swap(scene, done.scene);
    auto next = run_after(done, scene, sewing, adaptive, devices, *run, before, report);
    if (next) {
      adaptive.kept = std::move(done.kept);
      adaptive.compression = carried_compression(run->store.model(), adaptive.compression,
                                                 done.input_before, next->store.model());
      run = std::move(next);
      break;
    }
    std::swap(scene, done.scene);
    report.splits = report.flips = report.collapses = 0;
    ++report.redone;
  }
  if (view) {
    const double whole = energy_of(run->store).elastic;
    const SceneView seen =
        validate_run(scene, adaptive, run->store,
                     allowed_joules(scene, run->store.model(), adaptive, run->store.step_number));
    report.in_view = seen.in_view;
    report.factor_mean = seen.factor_mean;
    report.compression_jump =
        (energy_of(run->store).elastic - whole) - (seen_before - before.elastic);
  }
  report.vertices = run->store.model().cloth_vertex_count;
  report.triangles = run->store.model().cloth_triangle_count;
  report.seconds = seconds_since(start);
  report.cpu_seconds = cpu_seconds() - cpu_start;
  return report;
}

template RemeshReport remesh_step(Scene&, const Sewing&, AdaptiveRun&, DeviceSet&,
                                  std::unique_ptr<Run<float>>&);
template RemeshReport remesh_step(Scene&, const Sewing&, AdaptiveRun&, DeviceSet&,
                                  std::unique_ptr<Run<double>>&);

}  // namespace weft
