#include "host/time_parallel/slice_start.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "host/base/temporary_file.hpp"
#include "host/geometry/aabb.hpp"
#include "host/implicit/step.hpp"
#include "host/scene/frame_steps.hpp"
#include "host/scene/intersection_check.hpp"
#include "host/simulation/remeshing.hpp"
#include "host/state/checkpoint.hpp"
#include "host/state/store.hpp"
#include "host/time_parallel/coarse_states.hpp"
#include "host/time_parallel/frozen_meshes.hpp"
#include "host/time_parallel/placed_state.hpp"
#include "host/time_parallel/spin_up.hpp"
#include "weft/core/at.hpp"
#include "weft/error.hpp"

namespace weft {
namespace {

// What stages cost in products of one row, by the arithmetic that they take.
constexpr double assembly_cost = 30;  ///< a row, each time that the system is made
constexpr double contact_cost = 30;   ///< with the pairs around it, and their tests
constexpr double zone_cost = 0.5;     ///< a collision, each time that a pass comes to it
/// A row, each time that meshes are looked at and the model is rebuilt: 180 to 290 by the CPU
/// seconds of steps and remeshes of the method adaptive (`sphere` and `dress-blue` of ARCSim,
/// `drape`, `swing` and `flag`).
constexpr double remesh_cost = 250;
/// Share of the vertices whose change an iteration of recovery is checked by: those of a single
/// fold that slides would keep all others waiting.
constexpr double settled_share = 0.99;

/// Squared Frobenius norm of the matrix of an isotropic sheet, [[1, nu, 0], [nu, 1, 0], [0, 0, c]]
/// times k / (1 - nu^2).
double isotropic_norm_sq(double k, double nu) {
  const double scale = k / (1 - nu * nu);
  const double shear = (1 - nu) / 2;
  return scale * scale * (2 + 2 * nu * nu + shear * shear);
}

double stretch_norm_sq(const Material& m) {
  if (m.measured) {
    const auto& c = m.measured->rows[0];
    return 4 * (c[0] * c[0] + 2 * c[1] * c[1] + c[2] * c[2] + c[3] * c[3]);
  }
  if (m.orthotropic) {
    const OrthotropicStretch& o = *m.orthotropic;
    const double det = 1 - o.poisson_ratio * o.poisson_ratio * o.weft / o.warp;
    const double c11 = o.warp / det, c22 = o.weft / det, c12 = o.poisson_ratio * o.weft / det;
    return c11 * c11 + c22 * c22 + 2 * c12 * c12 + o.shear * o.shear;
  }
  return isotropic_norm_sq(m.stretch_stiffness, m.poisson_ratio);
}

double bending_norm_sq(const Material& m) {
  if (!m.orthotropic_bending) return isotropic_norm_sq(m.bending_stiffness, m.poisson_ratio);
  const OrthotropicBending& o = *m.orthotropic_bending;
  return o.warp * o.warp + o.weft * o.weft + 2 * o.coupling * o.coupling + o.twist * o.twist;
}

/// Algorithm 2 at one step, in the precision of the run.
template <class T>
class Recovery {
 public:
  /// @param level of the meshes that `fine` has
  /// @param run   null unless slices remesh
  Recovery(const Scene& fine, const CoarseScene& level, std::shared_ptr<CoarseStates> states,
           const StartTime& time, AdaptiveRun* run)
      : fine_(fine),
        devices_(host_devices(1)),
        store_(fine, devices_),
        implicit_(store_),
        level_(level),
        states_(std::move(states)),
        time_(time),
        run_(run) {}

  bool run(SliceStart& start, const std::function<bool(double work)>& go_on);
  void write(const std::filesystem::path& file) {
    write_checkpoint(file, fine_, store_.model(), store_.snapshot(), Sewing{},
                     run_ != nullptr ? adaptive_bytes(fine_, *run_) : std::string(),
                     fingerprint_of(fine_));
  }

 private:
  void begin(SliceStart& start);
  bool iterate(SliceStart& start);
  void refuse_intersecting() const;
  void hand_over_velocities();
  std::vector<Vec3<double>> internal(const std::vector<Vec3<double>>& inputs) const;

  const Scene& fine_;
  DeviceSet devices_;
  Store<T> store_;
  ImplicitStep<T> implicit_;
  const CoarseScene& level_;
  std::shared_ptr<CoarseStates> states_;
  StartTime time_;
  AdaptiveRun* run_;
  std::vector<Vec3<double>> moved_, accelerated_;  ///< change of the coarse run, internal order
  std::vector<Vec3<T>> velocities_;                ///< of the coarse run, internal order
};

template <class T>
std::vector<Vec3<double>> Recovery<T>::internal(const std::vector<Vec3<double>>& inputs) const {
  std::vector<Vec3<double>> result;
  for (const Index input : store_.model().to_input) result.push_back(inputs[at(input)]);
  return result;
}

/// The upsampled state, and what the coarse run does in the step before.
template <class T>
void Recovery<T>::begin(SliceStart& start) {
  const PlacedState placed = placed_state(fine_, store_.model(), *states_, time_);
  start.untangled = placed.untangled;
  StateSnapshot<T> state = snapshot_of(store_, placed, time_);
  velocities_ = state.velocities;
  store_.restore(state);
  if (fine_.method == "view") {
    constexpr double unlimited = std::numeric_limits<double>::infinity();
    validate_run(fine_, *run_, store_, unlimited);
  }
  const InputState now = states_->fine_state(time_.now);
  const InputState before = states_->fine_state(time_.before);
  const auto change = [&](const std::vector<Vec3<double>>& a, const std::vector<Vec3<double>>& b) {
    std::vector<Vec3<double>> d = internal(a);
    const std::vector<Vec3<double>> c = internal(b);
    for (std::size_t v = 0; v < d.size(); ++v) d[v] -= c[v];
    return d;
  };
  moved_ = change(now.positions, before.positions);
  accelerated_ = change(now.velocities, before.velocities);
}

/// What was parted may intersect again once it is rounded, and there are intersections that parting
/// does not see, such as cloth that is inside a body as a whole. No step would find either.
template <class T>
void Recovery<T>::refuse_intersecting() const {
  const StateSnapshot<T> state = store_.snapshot();
  const auto cloth = at(store_.model().cloth_vertex_count);
  std::vector<Vec3<double>> places(cloth), obstacles;
  for (std::size_t v = 0; v < cloth; ++v)
    places[at(store_.model().to_input[v])] = vec_cast<double>(state.positions[v]);
  for (std::size_t v = cloth; v < state.positions.size(); ++v)
    obstacles.push_back(vec_cast<double>(state.positions[v]));
  try {
    refuse_intersecting_start(scene_at(fine_, time_.now, places, obstacles));
  } catch (const SceneError& error) {
    throw SimulationError("the state made of the coarse run's for step " +
                          std::to_string(time_.step) + " intersects: " + error.what());
  }
}

/// One step back along the coarse run, and one forward.
/// @return whether the state has changed, and may change further
template <class T>
bool Recovery<T>::iterate(SliceStart& start) {
  const StateSnapshot<T> state = store_.snapshot();
  const auto cloth = at(store_.model().cloth_vertex_count);
  std::vector<Vec3<T>> places(state.positions.begin(),
                              state.positions.begin() + static_cast<std::ptrdiff_t>(cloth));
  for (std::size_t v = 0; v < cloth; ++v) places[v] -= vec_cast<T>(moved_[v]);
  StepReport report;
  const auto give_up = [&](const char* where) {
    store_.restore(state);
    start.note = std::string(where) + ": " + describe(report.failure);
    return false;
  };
  if (!implicit_.displace(places, time_.before, report)) return give_up("one step back");
  StateSnapshot<T> back = store_.snapshot();
  for (std::size_t v = 0; v < cloth; ++v) back.velocities[v] -= vec_cast<T>(accelerated_[v]);
  back.previous_step = 0;
  back.backoff = {};
  store_.restore(back);
  report = {};
  implicit_.advance(time_.length, report);
  start.work += counted_work(report, store_.model().cloth_vertex_count);
  if (report.failure != Failure::none) return give_up("one step forward");
  const StateSnapshot<T> next = without_history(store_.snapshot(), time_);
  store_.restore(next);
  start.tracking_error = report.tracking_error;
  ++start.iterations;
  std::vector<double> changes;
  for (std::size_t v = 0; v < cloth; ++v)
    changes.push_back(static_cast<double>(length(next.positions[v] - state.positions[v])));
  const auto most =
      changes.begin() +
      static_cast<std::ptrdiff_t>(std::ceil(settled_share * static_cast<double>(cloth - 1)));
  std::nth_element(changes.begin(), most, changes.end());
  start.change = *most / cloth_size(fine_);
  return start.change > fine_.time_parallel.recovery_tolerance;
}

/// Gives the state the coarse run's velocities. Steps forward leave two others in it: averages over
/// the coarse run's last step, which those of BDF2 are not, and the speed at which detail still
/// relaxes, which is none of the cloth's own.
template <class T>
void Recovery<T>::hand_over_velocities() {
  StateSnapshot<T> state = store_.snapshot();
  state.velocities = velocities_;
  store_.restore(without_history(std::move(state), time_));
}

template <class T>
bool Recovery<T>::run(SliceStart& start, const std::function<bool(double work)>& go_on) {
  begin(start);
  refuse_intersecting();
  implicit_.track(tracking_of(fine_, level_, states_));
  for (int i = 0; i < start.iterations_max; ++i) {
    if (!go_on(start.work)) return false;
    if (!iterate(start)) break;
  }
  implicit_.track(nullptr);
  hand_over_velocities();
  if (start.iterations > 0) refuse_intersecting();
  return true;
}

/// On the meshes that the fine scene has, or on those that the state asks for.
template <class T>
bool write_recovered(const Scene& fine, const CoarseScene& level, std::int64_t step,
                     const std::filesystem::path& directory, const std::filesystem::path& file,
                     const std::function<bool(double work)>& go_on, SliceStart& start) {
  const StartTime time(fine, step);
  const auto recover = [&](const Scene& on, const CoarseScene& of,
                           std::shared_ptr<CoarseStates> states, AdaptiveRun* run) {
    Recovery<T> recovery(on, of, std::move(states), time, run);
    if (!recovery.run(start, go_on)) return false;
    recovery.write(file);
    return true;
  };
  if (!remeshes(fine) && !remeshes(level.scene))
    return recover(fine, level, std::make_shared<CoarseStates>(level, directory), nullptr);
  FrozenMeshes frozen{fine, {}};
  const auto told = [&](double work) {
    start.work += work;
    return go_on(start.work);
  };
  if (remeshes(fine) && !freeze_meshes<T>(fine, level, time, directory, told, frozen)) return false;
  const auto states = std::make_shared<CoarseStates>(level, directory, frozen.fine);
  const CoarseScene coarse = states->level_at(time.now);
  return recover(frozen.fine, coarse, states, remeshes(fine) ? &frozen.run : nullptr);
}

/// Makes a start from the state of an earlier step, or of its own.
/// @return false: told to stop
/// @throws SimulationError if that state does not lead to one
bool write_from(const Scene& fine, const CoarseScene& level, std::int64_t from, std::int64_t step,
                const std::filesystem::path& states, const std::filesystem::path& file,
                const std::function<bool(double work)>& go_on, SliceStart& start) {
  const double earlier_work = start.work;
  start = {};
  start.work = earlier_work;
  start.spin_up = step - from;
  start.iterations_max = recovery_iterations(fine, frame_step_length(fine.time));
  const TemporaryFile earlier(std::filesystem::path(file).replace_extension("earlier"));
  std::filesystem::path begin;  // of the run-in
  if (from > 0) {
    begin = from == step ? file : earlier.path;
    const auto& write = fine.precision == Precision::single_precision ? write_recovered<float>
                                                                      : write_recovered<double>;
    if (!write(fine, level, from, states, begin, go_on, start)) return false;
  }
  if (from == step) return true;
  return spin_up(fine, begin, step, file, [&](double work) {
    start.work += work;
    return go_on(start.work);
  });
}

}  // namespace

double counted_work(const StepReport& report, std::int64_t rows) {
  const double each_row = static_cast<double>(report.iterations) + assembly_cost * report.solves;
  return each_row * static_cast<double>(rows) +
         contact_cost * static_cast<double>(report.proximities) +
         zone_cost * static_cast<double>(report.zone_visits) + remesh_work(report.remesh.vertices);
}

double remesh_work(std::int64_t rows) {
  return remesh_cost * static_cast<double>(rows);
}

std::int64_t cloth_rows(const Scene& scene) {
  return input_offsets(scene).back();
}

double least_work(std::int64_t rows) {
  return assembly_cost * static_cast<double>(rows);
}

int recovery_iterations(const Scene& scene, double step) {
  const TimeParallelSettings& settings = scene.time_parallel;
  if (settings.recovery_iterations >= 0) return settings.recovery_iterations;
  double most = 0;
  const auto add = [&](Index material) {
    const Material& m = scene.materials[at(material)];
    most = std::max(most, m.density / std::sqrt(stretch_norm_sq(m) + bending_norm_sq(m)));
  };
  for (const Cloth& cloth : scene.cloths) {
    if (cloth.triangle_material.empty()) add(cloth.material);
    for (const Index material : cloth.triangle_material) add(material);
  }
  return static_cast<int>(
      std::ceil(std::min(1e6, settings.recovery_factor * std::sqrt(most) / step)));
}

double cloth_size(const Scene& scene) {
  Aabb box;
  for (const Cloth& cloth : scene.cloths) box.include(aabb_of(cloth.mesh.positions));
  return box.longest_side();
}

SliceStart write_slice_start(const Scene& fine, const CoarseScene& level, std::int64_t step,
                             const std::filesystem::path& states, const std::filesystem::path& file,
                             const std::function<bool(double work)>& go_on) {
  std::filesystem::remove(file);  // of a run that was cut off before it said how this was made
  SliceStart start;
  std::string refused;
  const double each = frame_step_length(level.scene.time) / frame_step_length(fine.time);
  for (const std::int64_t from : spin_up_starts(step, each)) {
    try {
      write_from(fine, level, from, step, states, file, go_on, start);
      break;
    } catch (const SimulationError& error) {
      if (refused.empty()) refused = error.what();
      if (from == 0) throw;
    }
  }
  start.refused = refused;
  return start;
}

}  // namespace weft
