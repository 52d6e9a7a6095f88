#include "weft/simulation.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>

#include "host/asynchronous/step.hpp"
#include "host/exec/cpu_seconds.hpp"
#include "host/implicit/linear/pipelined_solve.hpp"
#include "host/implicit/sleep/sleeping_step.hpp"
#include "host/implicit/step.hpp"
#include "host/input/checker.hpp"
#include "host/input/quantity.hpp"
#include "host/model/refine.hpp"
#include "host/model/springs.hpp"
#include "host/scene/camera_check.hpp"
#include "host/scene/defaults.hpp"
#include "host/scene/frame_steps.hpp"
#include "host/scene/intersection_check.hpp"
#include "host/scene/origin.hpp"
#include "host/scene/part_check.hpp"
#include "host/simulation/bytes.hpp"
#include "host/simulation/cloth_positions.hpp"
#include "host/simulation/displaced_obstacles.hpp"
#include "host/simulation/live_inputs.hpp"
#include "host/simulation/remeshing.hpp"
#include "host/simulation/rest_count.hpp"
#include "host/simulation/seam_states.hpp"
#include "host/simulation/sew.hpp"
#include "host/simulation/simulation_access.hpp"
#include "host/simulation/single_user.hpp"
#include "host/simulation/step_control.hpp"
#include "host/state/checkpoint.hpp"
#include "host/state/energy.hpp"
#include "host/state/fingerprint.hpp"
#include "host/state/progress_board.hpp"
#include "host/state/transfer.hpp"
#include "host/untangle/untangle_scene.hpp"
#include "weft/core/at.hpp"
#include "weft/error.hpp"

namespace weft {
namespace {

/// Pairs of seams are welded at the end of every so many steps, and of every frame. Each welding
/// makes a new model and store; with one in every fourth step, the tube of scenes/README.md around
/// a moving body stays open.
constexpr std::int64_t weld_interval = 2;
/// If fewer than this share of the pairs could be welded, they wait for the end of the frame.
constexpr double weld_share = 0.125;
/// Most steps of one frame of advance().
constexpr double most_steps = 1e6;

/// State and method in one precision.
template <class T>
struct Run {
  Store<T> store;
  std::unique_ptr<ImplicitStep<T>> implicit;  ///< null with the method asynchronous
  std::unique_ptr<StepMethod> other;          ///< in its place, or around it where cloth may sleep
  ClothPositions<T> positions{store};

  /// @param before see Store
  Run(const Scene& scene, DeviceSet& devices, const Sewing& sewing, const Run* before = nullptr)
      : store(scene, devices, sewing.welded, before != nullptr ? &before->store : nullptr) {
    if constexpr (std::is_same_v<T, double>)
      if (scene.method == "asynchronous") {
        other = std::make_unique<AsynchronousStep>(store);
        return;
      }
    implicit = std::make_unique<ImplicitStep<T>>(
        store, before != nullptr ? before->implicit.get() : nullptr);
    if (scene.implicit.sleep_distance > 0)
      other = std::make_unique<SleepingStep<T>>(store, *implicit);
  }

  StepMethod& method() { return other ? *other : *implicit; }
  /// Whether cloth may sleep.
  bool sleeps() const { return implicit && other; }

  void advance(double dt, StepReport& report, ProgressBoard& board) {
    method().publish_on(board);
    method().advance(dt, report);
  }
};

using Runs =
    std::variant<std::monostate, std::unique_ptr<Run<float>>, std::unique_ptr<Run<double>>>;

/// A frame of Simulation::advance().
struct LiveFrame {
  double start = 0, end = 0;                  ///< [s]
  std::int64_t start_step = 0, end_step = 0;  ///< unless steps are automatic
  double length = 0;                          ///< [s] of its steps; 0: of the scene's
};

/// Lets a flag stop the devices while it lives; null: leaves to them what they have.
class StopFlag {
 public:
  StopFlag(DeviceSet& devices, const std::atomic<bool>* flag)
      : devices_(devices), before_(devices.stop_flag()) {
    if (flag != nullptr) devices_.stop_on(flag);
  }
  StopFlag(const StopFlag&) = delete;
  StopFlag& operator=(const StopFlag&) = delete;
  ~StopFlag() { devices_.stop_on(before_); }

 private:
  DeviceSet& devices_;
  const std::atomic<bool>* before_;
};

/// A step that is shown on the board until it ends, by whatever way.
class ShownStep {
 public:
  ShownStep(ProgressBoard& board, std::int64_t number) : board_(board) { board_.begin(number); }
  ShownStep(const ShownStep&) = delete;
  ShownStep& operator=(const ShownStep&) = delete;
  ~ShownStep() { board_.end(); }

 private:
  ProgressBoard& board_;
};

double total(const Energy& e) {
  return e.kinetic + e.elastic + e.gravitational;
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Refines a scene that has been sewn, if that is what it asks for.
/// @return for each level the parents of its inputs, see refine_cloths()
std::vector<std::vector<std::array<Index, 2>>> refine_if_sewn(Scene& scene, Sewing& sewing) {
  std::vector<std::vector<std::array<Index, 2>>> levels;
  if (scene.refinement.when != Refinement::When::sewn || !sewing.complete() || sewing.refined)
    return levels;
  for (int level = 0; level < scene.refinement.levels; ++level) {
    levels.push_back(refine_cloths(scene, joined_inputs(scene, sewing.welded)));
    sewing.welded.assign(seam_pairs(scene).size(), 1);
  }
  sewing.refined = true;
  return levels;
}

/// Puts vertices that are one at the start where they are one: at the mean of their places.
void join_at_start(Scene& scene, const Sewing& sewing) {
  std::vector<Vec3<double>> positions;
  for (const Cloth& cloth : scene.cloths)
    positions.insert(positions.end(), cloth.mesh.positions.begin(), cloth.mesh.positions.end());
  const std::vector<Index> joined = joined_inputs(scene, sewing.welded);
  average_joined(joined, positions);
  std::size_t input = 0;
  for (Cloth& cloth : scene.cloths)
    for (Vec3<double>& x : cloth.mesh.positions)
      x = positions[static_cast<std::size_t>(joined[input++])];
}

}  // namespace

const char* describe(Failure failure) {
  switch (failure) {
    case Failure::none:
      return "none";
    case Failure::not_finite:
      return "not finite";
    case Failure::not_converged:
      return "not converged";
    case Failure::intersection:
      return "intersection left";
    case Failure::pinched:
      return "pinched";
    case Failure::layers:
      return "out of penalty layers";
    case Failure::rollbacks:
      return "rolled back too often";
    case Failure::small_step:
      return "step too small";
    case Failure::stopped:
      return "stopped";
  }
  return "unknown";
}

const char* describe(FallbackLevel fallback_level) {
  switch (fallback_level) {
    case FallbackLevel::whole:
      return "whole";
    case FallbackLevel::halved:
      return "halved";
    case FallbackLevel::rigid:
      return "rigid";
    case FallbackLevel::truncated:
      return "truncated";
    case FallbackLevel::failed:
      return "failed";
  }
  return "unknown";
}

std::string AdvanceResult::message() const {
  if (failure == Failure::none) return {};
  return detail.empty() ? describe(failure) : describe(failure) + (": " + detail);
}

struct Simulation::Implementation {
  Scene scene;
  LiveInputs live;
  RestCount rest;
  Fingerprint fingerprint;  ///< of the scene as it was given
  Scene as_read;            ///< before refinement; empty unless it asks for that
  std::vector<Seam> seams_as_read;
  Sewing sewing;
  AdaptiveRun adaptive;  ///< of an adaptive method
  std::size_t pairs_as_read;
  DeviceSet devices;
  int steps_per_frame;
  Runs run;
  ProgressBoard board;
  SingleUser user;
  std::optional<LiveFrame> frame;                ///< of advance(), until it ends
  std::vector<std::vector<Vec3<float>>> places;  ///< [cloths] what positions() has given out

  template <class Use>
  auto visit(Use use) {
    const SingleUser::Use alone(user);
    if (auto* single = std::get_if<1>(&run)) return use(**single);
    return use(**std::get_if<2>(&run));
  }

  Implementation(Scene s, DeviceSet d) : scene(std::move(s)), devices(std::move(d)) {
    fill_in_defaults(scene);
    validate(scene);
    if (scene.method == "time_parallel")
      throw SceneError(scene.file, "method.type", "\"time_parallel\" for a run of single steps",
                       "the method of its slices; time_parallel is for whole runs");
    fingerprint = fingerprint_of(scene);
    live = LiveInputs(scene);
    restart_rest();
    choose_origin(scene);
    seams_as_read = scene.seams;
    sewing = sewing_at_start(scene);
    pairs_as_read = sewing.welded.size();
    if (scene.contact.untangle) untangle_start(scene, sewing.welded, [this] { go_on(); });
    go_on();
    refuse_intersecting_start(scene, sewing.welded);
    go_on();
    if (scene.method == "view") refuse_camera_inside(scene);
    steps_per_frame = scene.time.automatic ? 0 : frame_steps(scene.time);
    if (scene.method == "asynchronous" && devices.backend() != Backend::host)
      throw DeviceError("the method asynchronous runs on CPU threads only; use --device cpu");
    if (scene.refinement.when != Refinement::When::never) {
      // New vertices lie between the places where the old ones are one, not where they were read.
      if (sewing.complete()) join_at_start(scene, sewing);
      as_read = scene;
      if (!refine_if_sewn(scene, sewing).empty()) refuse_intersecting_start(scene, sewing.welded);
    }
    if (is_adaptive()) adaptive = begin_adaptive(scene);
    make_run();
    update_closing_times(true);
    go_on();
    if (is_adaptive()) remesh();
  }

  /// @throws StoppedError if whoever waits has asked for an end
  void go_on() const {
    if (devices.stop_requested()) throw StoppedError();
  }

  bool is_adaptive() const { return remeshes(scene); }

  void apply_forces() {
    const std::vector<Vec3<double>> forces = live.forces(scene);
    visit([&](auto& made) { made.store.apply_forces(forces); });
  }

  void make_run() {
    if (scene.precision == Precision::single_precision)
      run = std::make_unique<Run<float>>(scene, devices, sewing);
    else
      run = std::make_unique<Run<double>>(scene, devices, sewing);
    visit([this](auto& made) { made.store.set_compression(adaptive.compression); });
    apply_forces();
  }

  /// Makes model and stores again, of a scene that has changed in what they hold.
  void remake_run() {
    visit([this](auto& made) {
      using R = std::remove_reference_t<decltype(made)>;
      auto& current = std::get<std::unique_ptr<R>>(run);
      auto next = std::make_unique<R>(scene, devices, sewing, current.get());
      next->store.set_compression(adaptive.compression);
      next->store.restore(current->store.snapshot());
      current = std::move(next);
    });
    apply_forces();
  }

  /// Welds the pairs of seams that are close enough, and refines once all of them are welded.
  /// Not only at the end of a frame: pairs that have met and go on pulling for long fold the cloth
  /// beside them in between.
  /// @return [J] change of the cloth's energy
  template <class T>
  double sew(std::unique_ptr<Run<T>>& current, bool frame_ends, StepReport& report) {
    if (sewing.welded.empty() || sewing.complete()) return 0;
    Store<T>& store = current->store;
    if (frame_ends) sewing.refused.clear();
    Welding<T> welding =
        weld_close_pairs(store, *current->implicit, sewing, frame_ends ? 0 : weld_share, report);
    sewing.refused = std::move(welding.refused);
    if (!welding.state) return 0;
    const double before = total(energy_of(store));
    sewing.welded = std::move(welding.welded);
    // The store refers to the scene, which may be refined now; its model stays as it was.
    const auto levels = refine_if_sewn(scene, sewing);
    auto next = std::make_unique<Run<T>>(scene, devices, sewing, current.get());
    next->store.restore(transferred(store.model(), *welding.state, levels, next->store.model()));
    current = std::move(next);
    apply_forces();
    return total(energy_of(current->store)) - before;
  }

  void update_closing_times(bool frame_ends) {
    visit([&](auto& made) {
      weft::update_closing_times(seams_as_read, made.store, frame_ends, sewing);
    });
  }

  /// Brings the meshes of an adaptive method to what their state asks for.
  RemeshReport remesh() {
    if (auto* single = std::get_if<1>(&run)) return remesh(*single);
    return remesh(*std::get_if<2>(&run));
  }
  template <class T>
  RemeshReport remesh(std::unique_ptr<Run<T>>& current) {
    const auto start = std::chrono::steady_clock::now();
    const double cpu_start = cpu_seconds();
    RemeshReport report;
    // That of the material itself: how it yields out of view is decided each time.
    current->store.set_compression({});
    const Energy before = energy_of(current->store);
    adaptive.peak_kinetic = std::max(adaptive.peak_kinetic, before.kinetic);
    // What changes the energy too much is tried once more with less, and then left for later.
    for (int tries = 0; tries < 2; ++tries) {
      MeshesBefore meshes = meshes_of(scene, adaptive);
      const SceneRemesh done = remesh_run(scene, sewing.welded, adaptive, current->store, tries);
      add_counts(done.counts, report);
      if (!done.changed() || take_over(current, done, before, report)) break;
      take_back(std::move(meshes), scene, adaptive);
      report.splits = report.flips = report.collapses = 0;
      ++report.redone;
    }
    if (scene.method == "view") {
      const SceneView view = validate_run(scene, adaptive, current->store);
      report.in_view = view.in_view;
      report.factor_mean = view.factor_mean;
    }
    report.vertices = current->store.model().cloth_vertex_count;
    report.triangles = current->store.model().cloth_triangle_count;
    report.seconds = seconds_since(start);
    report.cpu_seconds = cpu_seconds() - cpu_start;
    return report;
  }

  static void add_counts(const RemeshCounts& counts, RemeshReport& report) {
    report.splits = counts.splits;
    report.flips = counts.flips;
    report.collapses = counts.collapses;
    report.refused += counts.refused;
  }

  /// Goes on with the meshes that a remesh has given the scene.
  /// @return false if that changes the energy too much: the run is as it was
  template <class T>
  bool take_over(std::unique_ptr<Run<T>>& current, const SceneRemesh& done, const Energy& before,
                 RemeshReport& report) {
    const auto rebuild = std::chrono::steady_clock::now();
    auto next = std::make_unique<Run<T>>(scene, devices, sewing, current.get());
    const Model& from = current->store.model();
    const StateSnapshot<T> state = current->store.snapshot();
    StateSnapshot<T> now = remeshed_state(from, state, done, next->store.model());
    next->store.restore(now);
    report.rebuild_seconds += seconds_since(rebuild);
    const Energy after = energy_of(next->store);
    double jump = surface_kinetic(scene, next->store.model(), now.velocities) -
                  surface_kinetic(scene, from, state.velocities) +
                  (after.elastic - before.elastic) + (after.gravitational - before.gravitational);
    if (jump > 0) {
      jump -= pay_from_motion(scene, next->store.model(), done, jump, now);
      next->store.restore(now);
    }
    if (!(std::abs(jump) <= largest_jump(scene, from, adaptive, state.step_number))) return false;
    report.energy_jump = jump;
    current = std::move(next);
    return true;
  }

  template <class T>
  Energy energy_of(Store<T>& store) const {
    const auto snapshot = store.snapshot();
    const Model& model = store.model();
    return measure_energy(scene, model, cast_all<double>(snapshot.positions),
                          cast_all<double>(snapshot.velocities),
                          springs_at(scene, model, snapshot.time),
                          *store.plate(fixed_vertices(scene, model, snapshot.time)));
  }

  /// Of the present state; empty if no material has strain limits.
  std::optional<double> limit_excess() {
    return visit([](auto& made) -> std::optional<double> {
      const Model& model = made.store.model();
      if (!has_limits(model.laws->rows)) return {};
      return largest_limit_excess(model, cast_all<double>(made.store.snapshot().positions));
    });
  }

  /// Counts a frame that has ended.
  void count_rest() {
    visit([this](auto& made) {
      const auto snapshot = made.store.snapshot();
      rest.add_frame(Span(snapshot.velocities.data(), snapshot.velocities.size()), snapshot.time,
                     quiet_frames_of_rest(scene.time));
    });
  }

  void restart_rest() { rest.reset(last_change(scene)); }

  /// Makes scene and topology those of a run that has come as far as `to`.
  /// @param origin of that run
  void sew_as(const Sewing& to, const Vec3<double>& origin) {
    if (scene.refinement.when != Refinement::When::never) scene = as_read;
    move_origin(scene, origin);
    sewing = to;
    if (to.refined) {
      sewing.refined = false;
      refine_if_sewn(scene, sewing);
    }
  }

  StepControl step_control() const { return {scene.time, scene.integrator}; }

  /// [s] of the next step
  double step_length() {
    if (!scene.time.automatic) return frame_step_length(scene.time);
    return visit([this](auto& made) {
      return step_control().next(made.store.next_step, made.store.time).length;
    });
  }

  bool at_frame_end() {
    return visit([this](auto& made) {
      if (scene.time.automatic) return step_control().at_frame_end(made.store.time);
      if (has_counted_time(made.store) && !has_own_steps())
        return made.store.step_number % steps_per_frame == 0;
      return !frame || made.store.step_number >= frame->end_step;
    });
  }

  /// Whether a state's time is that of so many of the scene's steps, and not what frames of the
  /// program's own lengths have made of it.
  template <class T>
  bool has_counted_time(const Store<T>& store) const {
    return scene.time.automatic ||
           store.time == static_cast<double>(store.step_number) * frame_step_length(scene.time);
  }
  /// Whether a frame is under way whose steps are not the scene's.
  bool has_own_steps() const { return frame && frame->length > 0; }

  /// One step of the scene's length, or the frame's.
  template <class T>
  void advance_fixed(Run<T>& made, StepReport& report) {
    const double length = has_own_steps() ? frame->length : frame_step_length(scene.time);
    // Counted, not summed up, so that a resumed run sees the same times.
    double end = static_cast<double>(report.number) * length;
    if (has_own_steps())
      end = report.number == frame->end_step
                ? frame->end
                : frame->start + static_cast<double>(report.number - frame->start_step) * length;
    else if (!has_counted_time(made.store))
      end = made.store.time + length;
    report.step = length;
    // Pieces fall asleep and wake while a step is tried. Other steps go back by themselves.
    std::optional<StateSnapshot<T>> start;
    if (made.sleeps()) start = made.store.snapshot();
    made.advance(length, report, board);
    if (report.failure != Failure::none && start) made.store.restore(*start);
    if (report.failure == Failure::none) made.store.time = end;
  }

  /// One step of the length that its error allows. Attempts that are too long are taken back.
  template <class T>
  void advance_automatic(Run<T>& made, StepReport& report) {
    Store<T>& store = made.store;
    const StepControl control = step_control();
    const Backoff backoff = store.backoff;
    double wanted = store.next_step;
    while (true) {
      const StepControl::Step step = control.next(wanted, store.time);
      report.step = step.length;
      store.keep();
      made.advance(step.length, report, board);
      if (report.failure != Failure::none) return;
      const double error = *report.step_error;
      // A step that was bisected has been taken in shorter parts already.
      const bool whole = report.fallback_level == FallbackLevel::whole;
      if (!whole || !control.rejects(step, error, report.rejected)) {
        store.next_step = control.after(step, error, whole && report.rejected == 0);
        store.time = step.end;
        return;
      }
      store.go_back();
      store.backoff = backoff;
      wanted = control.again(step, error);
      ++report.rejected;
      report.compliant = 0;
      report.compliance_distance = 0;
    }
  }

  std::string live_bytes() {
    const std::string bytes = live.bytes(scene);
    const bool counted = visit([this](auto& made) { return has_counted_time(made.store); });
    if (bytes.empty() && !frame && counted) return {};
    Packer packer;
    packer.put(frame.value_or(LiveFrame{}));
    packer.put(static_cast<unsigned char>(frame ? 1 : 0));
    packer.put(static_cast<unsigned char>(counted ? 1 : 0));
    return packer.bytes + bytes;
  }

  /// Sets what a program had set when it wrote a checkpoint.
  /// @param bytes of live_bytes()
  /// @return whether the checkpoint's time is counted, see has_counted_time()
  bool set_live(const std::string& bytes, const std::string& file) {
    frame.reset();
    if (bytes.empty()) {
      live.read({}, file, scene);
      return true;
    }
    LiveFrame read;
    unsigned char interrupted = 0, counted = 0;
    constexpr std::size_t size = sizeof read + sizeof interrupted + sizeof counted;
    const std::string head = bytes.substr(0, size);
    Unpacker unpacker(head, file, "live", "what the program had set");
    unpacker.get(read);
    unpacker.get(interrupted);
    unpacker.get(counted);
    if (interrupted > 1 || counted > 1 || !std::isfinite(read.start + read.end + read.length) ||
        read.length < 0 || read.start_step < 0 || read.end_step < read.start_step)
      unpacker.refuse("has values that cannot be");
    if (interrupted != 0) frame = read;
    live.read(bytes.substr(size), file, scene);
    return counted != 0;
  }

  std::vector<std::string> resume(const CheckpointReader& in, SceneChanges changes) {
    const std::vector<std::string> differences =
        differences_between(read_fingerprint(in), fingerprint);
    if (changes == SceneChanges::refuse) refuse_differences(differences, in.name());
    const auto load = [&](bool counted) {
      visit([&](auto& made) {
        auto snapshot = made.store.snapshot();
        read_checkpoint(in, scene, made.store.model(), snapshot);
        if (counted) count_steps(snapshot, in.name());
        made.store.restore(snapshot);
      });
    };
    const Sewing to = read_sewing(in, pairs_as_read, seams_as_read.size());
    const std::string inputs = read_live(in);
    // Another one than this scene's if other cloths were there, or none was chosen.
    const Vec3<double> origin = read_origin(in);
    if (to == sewing && !to.refined && !is_adaptive() && origin == origin_of(scene) &&
        inputs.empty() && live_bytes().empty()) {
      load(true);
      return differences;
    }
    // If the checkpoint turns out not to fit, everything has to be as it was.
    Scene scene_before = scene;
    Sewing sewing_before = sewing;
    AdaptiveRun adaptive_before = adaptive;
    LiveInputs live_before = live;
    const std::optional<LiveFrame> frame_before = frame;
    Runs run_before = std::move(run);
    try {
      move_origin(scene, origin);
      if (is_adaptive()) read_adaptive_bytes(read_adaptive(in), in.name(), scene, adaptive);
      sew_as(to, origin);
      const bool counted = set_live(inputs, in.name());
      make_run();
      load(counted);
    } catch (...) {
      scene = std::move(scene_before);
      adaptive = std::move(adaptive_before);
      sewing = std::move(sewing_before);
      live = std::move(live_before);
      frame = frame_before;
      run = std::move(run_before);
      throw;
    }
    return differences;
  }

  /// resume(), with the count of quiet frames, which a changed scene starts again.
  std::vector<std::string> resume_with_rest(const CheckpointReader& in, SceneChanges changes) {
    const std::int32_t quiet = read_quiet_frames(in);
    std::vector<std::string> differences = resume(in, changes);
    restart_rest();
    if (differences.empty() && scene.time.until == RunUntil::rest)
      rest.restore(quiet, quiet_frames_of_rest(scene.time));
    return differences;
  }

  /// The frame that begins now.
  LiveFrame frame_of(double seconds) {
    const bool automatic = scene.time.automatic;
    const double unit = automatic ? 1 / scene.time.frame_rate : frame_step_length(scene.time);
    const double count = std::round(seconds / unit);
    const bool whole = std::abs(seconds - count * unit) <= 1e-6 * unit && count >= 1;
    if (!(seconds > 0 && seconds <= most_steps * unit) || (automatic && !whole))
      throw SceneError(scene.file, "advance", text_of(seconds) + " s",
                       automatic
                           ? "a whole number of frames of " + text_of(unit) + " s, at least one"
                           : "a time > 0, of at most a million steps");
    return visit([&](auto& made) -> LiveFrame {
      const double start = made.store.time;
      if (automatic) {
        const int frames = step_control().frames(start) + static_cast<int>(count);
        return {start, frame_time(scene.time, frames), 0, 0, 0};
      }
      const std::int64_t first = made.store.step_number;
      if (whole && has_counted_time(made.store)) {
        const std::int64_t last = first + static_cast<std::int64_t>(count);
        return {start, static_cast<double>(last) * unit, first, last, 0};
      }
      // Steps of one length, no longer than the scene's.
      const double steps = std::max(1.0, std::ceil(seconds / unit * (1 - 1e-9)));
      return {start, start + seconds, first, first + static_cast<std::int64_t>(steps),
              seconds / steps};
    });
  }

  bool frame_ended() {
    return visit([this](auto& made) {
      return scene.time.automatic ? made.store.time >= frame->end
                                  : made.store.step_number >= frame->end_step;
    });
  }

  /// Numbers the steps of a state as this scene does, whose steps may be of another length.
  /// @throws SceneError if its time is not at the end of one of them
  template <class T>
  void count_steps(StateSnapshot<T>& state, const std::string& file) const {
    if (scene.time.automatic) {
      // Frames are those of the scene, to the bit.
      const double end = frame_time(scene.time, step_control().frames(state.time));
      if (std::abs(state.time - end) <= 1e-9 / scene.time.frame_rate) state.time = end;
      return;
    }
    const double length = frame_step_length(scene.time);
    const auto number = std::llround(state.time / length);
    if (number == state.step_number) return;
    if (!(std::abs(static_cast<double>(number) * length - state.time) <= 1e-9 * length))
      throw SceneError(file, "checkpoint time", text_of(state.time) + " s",
                       "the end of a step of " + text_of(length) + " s");
    state.step_number = number;
    state.sleep = {};  // which counts steps too
  }
};

Simulation::Simulation(Scene scene, DeviceSet devices)
    : implementation_(std::make_unique<Implementation>(std::move(scene), std::move(devices))) {}
Simulation::Simulation(Scene scene, AutoDevice) {
  validate(scene);
  DeviceSet devices = parse_devices(choose_devices(scene).device);
  implementation_ = std::make_unique<Implementation>(std::move(scene), std::move(devices));
}
Simulation::~Simulation() = default;
Simulation::Simulation(Simulation&&) noexcept = default;
Simulation& Simulation::operator=(Simulation&&) noexcept = default;

const Scene& Simulation::scene() const {
  return implementation_->scene;
}
Vec3<double> Simulation::origin() const {
  return origin_of(implementation_->scene);
}
int Simulation::steps_per_frame() const {
  return implementation_->steps_per_frame;
}
double Simulation::step_length() const {
  return implementation_->step_length();
}

StepReport Simulation::step() {
  const SingleUser::Use alone(implementation_->user);
  ProgressBoard& board = implementation_->board;
  const ShownStep shown(board, step_number() + 1);
  StepReport report = implementation_->visit([this](auto& run) {
    StepReport r;
    r.number = run.store.step_number + 1;
    if (scene().time.automatic)
      implementation_->advance_automatic(run, r);
    else
      implementation_->advance_fixed(run, r);
    if (r.failure == Failure::none) run.store.step_number = r.number;
    r.time = run.store.time;
    return r;
  });
  Implementation& i = *implementation_;
  if (report.failure == Failure::none) {
    const bool frame_ends = i.at_frame_end();
    if (frame_ends) board.enter(StepStage::remeshing);
    double changed = 0;
    if (frame_ends || report.number % weld_interval == 0) {
      if (auto* single = std::get_if<1>(&i.run)) changed += i.sew(*single, frame_ends, report);
      if (auto* twice = std::get_if<2>(&i.run)) changed += i.sew(*twice, frame_ends, report);
      i.update_closing_times(frame_ends);
    }
    if (frame_ends && i.is_adaptive()) {
      const double before = total(energy());
      report.remesh = i.remesh();
      changed += total(energy()) - before;
    }
    if (report.work) *report.work += changed;
    if (frame_ends) report.limit_excess = i.limit_excess();
    if (frame_ends && i.scene.time.until == RunUntil::rest) {
      i.count_rest();
      report.moving_share = i.rest.state().moving_share;
    }
  }
  if (report.failure_place) *report.failure_place += origin();
  report.open_seam_pairs =
      std::count(i.sewing.welded.begin(), i.sewing.welded.end(), static_cast<unsigned char>(0));
  return report;
}

StepProgress Simulation::progress() const noexcept {
  return implementation_->board.read();
}

std::int64_t Simulation::step_number() const {
  return implementation_->visit([](auto& run) { return run.store.step_number; });
}

double Simulation::time() const {
  return implementation_->visit([](auto& run) { return run.store.time; });
}

int Simulation::frame_number() const {
  Implementation& i = *implementation_;
  if (scene().time.automatic) return i.step_control().frames(time());
  const bool counted = i.visit([&i](auto& run) { return i.has_counted_time(run.store); });
  if (counted) return static_cast<int>(step_number() / steps_per_frame());
  return static_cast<int>(std::floor(time() * scene().time.frame_rate * (1 + 1e-12)));
}

bool Simulation::at_frame_end() const {
  return implementation_->at_frame_end();
}

RestState Simulation::rest() const {
  return implementation_->rest.state();
}

Frame Simulation::frame() const {
  Frame frame = local_frame();
  const Vec3<double> zero{0, 0, 0};
  const Vec3<double> origin = std::exchange(frame.origin, zero);
  if (origin == zero) return frame;
  for (auto* surfaces :
       {&frame.cloth_positions, &frame.obstacle_positions, &frame.displaced_obstacle_positions})
    for (auto& positions : *surfaces)
      for (Vec3<double>& x : positions) x += origin;
  return frame;
}

Frame Simulation::local_frame() const {
  return implementation_->visit([this](auto& run) {
    const Model& model = run.store.model();
    const Scene& s = scene();
    const auto snapshot = run.store.snapshot();
    Frame frame;
    frame.number = frame_number();
    frame.time = snapshot.time;
    frame.origin = origin_of(s);
    for (std::size_t c = 0; c < s.cloths.size(); ++c) {
      frame.cloth_positions.emplace_back();
      frame.cloth_velocities.emplace_back();
      for (Index input = model.input_offset[c]; input < model.input_offset[c + 1]; ++input) {
        const auto v = static_cast<std::size_t>(model.to_internal[static_cast<std::size_t>(input)]);
        frame.cloth_positions.back().push_back(vec_cast<double>(snapshot.positions[v]));
        frame.cloth_velocities.back().push_back(vec_cast<double>(snapshot.velocities[v]));
      }
    }
    frame.obstacle_positions.resize(s.obstacles.size());
    for (std::size_t i = 0; i < model.obstacle_of_vertex.size(); ++i)
      frame.obstacle_positions[static_cast<std::size_t>(model.obstacle_of_vertex[i])].push_back(
          vec_cast<double>(
              snapshot.positions[static_cast<std::size_t>(model.cloth_vertex_count) + i]));
    // With the method asynchronous cloth never displaces an obstacle, and forces drive some.
    if (run.implicit) separate_displaced(s, model, frame, s.precision);
    return frame;
  });
}

Energy Simulation::energy() const {
  return implementation_->visit(
      [this](auto& run) { return implementation_->energy_of(run.store); });
}

std::vector<SeamState> Simulation::seams() const {
  return implementation_->visit([this](auto& run) {
    return seam_states(implementation_->seams_as_read, implementation_->sewing, run.store);
  });
}

std::uint64_t Simulation::state_hash() const {
  return implementation_->visit(
      [](auto& run) { return hash_state(run.store.model(), run.store.snapshot()); });
}

AdvanceResult Simulation::advance(double seconds, const AdvanceOptions& options) {
  const SingleUser::Use alone(implementation_->user);
  const auto start = std::chrono::steady_clock::now();
  Implementation& i = *implementation_;
  if (!i.frame) {
    i.frame = i.frame_of(seconds);
    i.live.begin_frame(time(), i.frame->end);
  }
  std::atomic<bool> stop{false};
  const std::stop_callback listen(options.stop, [&stop] { stop = true; });
  const StopFlag flag(i.devices, options.stop.stop_possible() ? &stop : nullptr);
  AdvanceResult result;
  do {
    StepReport report = step();
    if (report.failure != Failure::none) {
      result.failure = report.failure;
      result.detail = std::move(report.failure_detail);
      return result;
    }
    ++result.steps;
    result.complete = i.frame_ended();
  } while (!result.complete &&
           !(options.budget && std::chrono::steady_clock::now() - start >= *options.budget));
  if (result.complete) i.frame.reset();
  return result;
}

void Simulation::move(ObstacleId obstacle, std::span<const Vec3<double>> places) {
  const SingleUser::Use alone(implementation_->user);
  Implementation& i = *implementation_;
  i.live.move(i.scene, obstacle, {places.data(), places.size()});
  i.restart_rest();
}

void Simulation::move(PinId pin, std::span<const Vec3<double>> places) {
  const SingleUser::Use alone(implementation_->user);
  Implementation& i = *implementation_;
  if (i.live.move(i.scene, pin, {places.data(), places.size()})) i.remake_run();
  i.restart_rest();
}

void Simulation::release(PinId pin) {
  const SingleUser::Use alone(implementation_->user);
  Implementation& i = *implementation_;
  refuse_foreign(i.scene, pin, i.scene.pins.size(), "pins");
  Pin& released = i.scene.pins[at(pin.index)];
  released.release_time = std::min(released.release_time, time());
  i.restart_rest();
}

void Simulation::set_gravity(const Vec3<double>& gravity) {
  const SingleUser::Use alone(implementation_->user);
  Implementation& i = *implementation_;
  Checker(i.scene.file, {}).within("gravity", gravity, quantity::acceleration);
  if (gravity == i.scene.gravity) return;
  i.scene.gravity = gravity;
  i.restart_rest();
  // Near their limits, materials stiffen by what the cloth weighs.
  if (i.visit([](auto& run) { return has_limits(run.store.model().laws->rows); })) i.remake_run();
}

void Simulation::set_forces(ClothId cloth, std::span<const Vec3<double>> forces) {
  const SingleUser::Use alone(implementation_->user);
  Implementation& i = *implementation_;
  i.live.set_forces(i.scene, cloth, {forces.data(), forces.size()});
  i.apply_forces();
  i.restart_rest();
}

void Simulation::set_wind(const Wind& wind) {
  const SingleUser::Use alone(implementation_->user);
  Implementation& i = *implementation_;
  const Wind before = std::exchange(i.scene.wind, wind);
  try {
    validate_wind(i.scene);
  } catch (...) {
    i.scene.wind = before;
    throw;
  }
  // Its buffers are made where air moves.
  if ((before.density > 0 || before.drag > 0) != (wind.density > 0 || wind.drag > 0))
    i.remake_run();
  i.restart_rest();
}

std::span<const Vec3<float>> Simulation::positions(ClothId cloth) {
  const SingleUser::Use alone(implementation_->user);
  Implementation& i = *implementation_;
  refuse_foreign(i.scene, cloth, i.scene.cloths.size(), "cloths");
  i.places.resize(i.scene.cloths.size());
  std::vector<Vec3<float>>& places = i.places[at(cloth.index)];
  i.visit([&](auto& run) { run.positions.download(at(cloth.index), origin(), places); });
  return places;
}

DevicePositions Simulation::device_positions(ClothId cloth, void* stream) {
  const SingleUser::Use alone(implementation_->user);
  Implementation& i = *implementation_;
  refuse_foreign(i.scene, cloth, i.scene.cloths.size(), "cloths");
  return i.visit(
      [&](auto& run) { return run.positions.on_device(at(cloth.index), origin(), stream); });
}

Transport Simulation::transport() const {
  return choose_transport(implementation_->scene.solver, implementation_->devices);
}

std::vector<std::size_t> Simulation::peak_device_bytes() const {
  std::vector<std::size_t> bytes;
  for (int r = 0; r < implementation_->devices.size(); ++r)
    bytes.push_back(implementation_->devices[r].peak_bytes());
  return bytes;
}

std::vector<std::vector<MemoryUse>> Simulation::device_memory() const {
  std::vector<std::vector<MemoryUse>> uses;
  for (int r = 0; r < implementation_->devices.size(); ++r)
    uses.push_back(implementation_->devices[r].memory_use());
  return uses;
}

void SimulationAccess::track(Simulation& simulation,
                             const std::shared_ptr<const Tracking>& tracking) {
  simulation.implementation_->visit([&](auto& run) {
    if (run.implicit) run.implicit->track(tracking);
  });
}

std::string Simulation::state() const {
  const SingleUser::Use alone(implementation_->user);
  return implementation_->visit([&](auto& run) {
    Implementation& i = *implementation_;
    Sewing sewing = i.sewing;
    if (sewing.refined) sewing.welded.assign(i.pairs_as_read, 1);
    return checkpoint_bytes(scene(), run.store.model(), run.store.snapshot(), sewing,
                            i.is_adaptive() ? adaptive_bytes(scene(), i.adaptive) : std::string(),
                            i.live_bytes(), i.fingerprint, i.rest.state().quiet_frames);
  });
}

void Simulation::save(const std::filesystem::path& file, bool synced) const {
  write_file_atomically(file, state(), synced ? Durability::fsync : Durability::none);
}

std::vector<std::string> Simulation::restore(const std::string& state, SceneChanges changes) {
  const SingleUser::Use alone(implementation_->user);
  return implementation_->resume_with_rest(CheckpointReader(state, "state"), changes);
}

std::vector<std::string> Simulation::resume(const std::filesystem::path& file,
                                            SceneChanges changes) {
  const SingleUser::Use alone(implementation_->user);
  return implementation_->resume_with_rest(CheckpointReader(file), changes);
}

}  // namespace weft
