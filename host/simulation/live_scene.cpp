#include "host/simulation/live_scene.hpp"

#include <algorithm>
#include <exception>
#include <tuple>

#include "host/input/checker.hpp"
#include "host/input/quantity.hpp"
#include "host/model/material_rows.hpp"
#include "host/model/refine.hpp"
#include "host/model/springs.hpp"
#include "host/scene/camera_check.hpp"
#include "host/scene/defaults.hpp"
#include "host/scene/intersection_check.hpp"
#include "host/scene/method_check.hpp"
#include "host/scene/origin.hpp"
#include "host/scene/part_check.hpp"
#include "host/simulation/handle_states.hpp"
#include "host/simulation/remesh_step.hpp"
#include "host/simulation/seam_states.hpp"
#include "host/simulation/sew.hpp"
#include "host/simulation/state_energy.hpp"
#include "host/simulation/weld_open_pairs.hpp"
#include "host/state/energy.hpp"
#include "host/state/transfer.hpp"
#include "host/untangle/untangle_scene.hpp"
#include "weft/core/at.hpp"
#include "weft/error.hpp"

namespace weft {
namespace {

/// The model is made again each time that pairs are welded. If fewer than this share of all pairs
/// could be, they wait for the end of the frame.
constexpr double weld_share = 0.125;
/// If fewer than this share of the open pairs could be welded then, they wait for the end of every
/// fifth frame, or of the last. Not in runs until rest: any frame may be their last.
constexpr double weld_share_of_open = 0.5;
constexpr int frames_per_straggler = 5;

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

LiveScene::LiveScene(Scene scene, DeviceSet& devices)
    : scene_(std::move(scene)), devices_(devices) {
  fill_in_defaults(scene_);
  validate(scene_);
  if (scene_.method == "time_parallel")
    throw SceneError(scene_.file, "method.type", "\"time_parallel\" for a run of single steps",
                     "the method of its slices; time_parallel is for whole runs");
  fingerprint_ = fingerprint_of(scene_);
  live_ = LiveInputs(scene_);
  restart_rest();
  clock_ = FrameClock(scene_);
  choose_origin(scene_);
  seams_as_read_ = scene_.seams;
  begin_sewing();
  pairs_as_read_ = sewing_.welded.size();
  if (scene_.method == "view") refuse_camera_inside(scene_);
  if (scene_.method == "asynchronous" && devices.backend() != Backend::host)
    throw DeviceError("the method asynchronous runs on CPU threads only; use --device cpu");
  if (scene_.refinement.when != Refinement::When::never) {
    // New vertices lie between the places where the old ones are one, not where they were read.
    if (sewing_.complete()) join_at_start(scene_, sewing_);
    as_read_ = scene_;
    if (!refine_if_sewn().empty()) refuse_intersecting_start(scene_, sewing_.welded);
  }
  if (is_adaptive()) adaptive_ = begin_adaptive(scene_);
  make_run();
  update_closing_times(true);
  go_on();
  if (is_adaptive()) remesh();
}

/// Moves cloth of which nothing must intersect at the start, if the scene allows that.
/// @throws SceneError if something still does
void LiveScene::part_start() {
  sewing_ = sewing_at_start(scene_);
  if (scene_.contact.untangle) untangle_start(scene_, sewing_.welded, [this] { go_on(); });
  go_on();
  refuse_intersecting_start(scene_, sewing_.welded);
  go_on();
}

/// Begins with garments sewn as they ask for. Those that leave it open are welded, or all closed by
/// springs if that start is refused.
/// @throws SceneError if neither can be parted: why the welded start was refused
void LiveScene::begin_sewing() {
  std::vector<GarmentStart> starts = std::exchange(scene_.garment_starts, {});
  const auto stand_apart = [&](SewnStart kind) {
    bool any = false;
    for (GarmentStart& start : starts) {
      if (start.start != kind) continue;
      if (!start.apart.empty()) scene_.cloths[at(start.cloth)].mesh.positions = start.apart;
      start.start = SewnStart::springs;
      any = true;
    }
    return any;
  };
  bool springs = stand_apart(SewnStart::springs);
  const std::vector<Cloth> as_read = starts.empty() ? std::vector<Cloth>() : scene_.cloths;
  try {
    part_start();
  } catch (const SceneError& refusal) {
    if (!starts.empty()) scene_.cloths = as_read;
    if (!stand_apart(SewnStart::automatic)) throw;
    springs = true;
    for (GarmentStart& start : starts)
      if (start.start == SewnStart::springs && start.reason.empty()) start.reason = refusal.what();
    const auto refused = std::current_exception();
    try {
      part_start();
    } catch (const SceneError&) {
      std::rethrow_exception(refused);
    }
  }
  for (GarmentStart& start : starts) {
    if (start.start == SewnStart::automatic) start.start = SewnStart::welded;
    start.apart.clear();
  }
  scene_.garment_starts = std::move(starts);
  if (springs && !sewing_.complete()) {
    sewn_gravity_ = scene_.gravity;
    scene_.gravity = {0, 0, 0};
    weightless_ = true;
    restart_rest();
  }
}

/// [s] until when the springs of seams grow stiffer.
double LiveScene::end_of_pull() const {
  double last = 0;
  for (const Seam& seam : scene_.seams)
    last = std::max(last, seam.start_time + longest_pull * seam.ramp_time);
  return last;
}

/// Lets gravity act once all seams are closed, or springs have pulled as hard as they ever do: a
/// pair that folded cloth keeps open may then come free.
/// @return [J] change of the cloth's energy
double LiveScene::let_fall() {
  if (!weightless_ || (!sewing_.complete() && time() < end_of_pull())) return 0;
  const double before = energy().total();
  set_gravity(*sewn_gravity_);
  return energy().total() - before;
}

/// While springs still pull garments together, cloth that hardly moves does not rest.
void LiveScene::restart_rest() {
  rest_.reset(weightless_ ? std::max(last_change(scene_), end_of_pull()) : last_change(scene_));
}

bool LiveScene::is_adaptive() const {
  return remeshes(scene_);
}

/// @throws StoppedError if whoever waits has asked for an end
void LiveScene::go_on() const {
  if (devices_.stop_requested()) throw StoppedError();
}

double LiveScene::time() {
  return visit([](auto& run) { return run.store.time; });
}

std::int64_t LiveScene::step_number() {
  return visit([](auto& run) { return run.store.step_number; });
}

bool LiveScene::counts() {
  return clock_.counts(time(), step_number());
}

bool LiveScene::at_frame_end() {
  return clock_.at_frame_end(time(), step_number());
}

double LiveScene::step_length() {
  return visit(
      [this](auto& run) { return clock_.step_length(run.store.time, run.store.next_step); });
}

int LiveScene::frame_number() {
  return clock_.frame_number(time(), step_number());
}

Energy LiveScene::energy() {
  return visit([](auto& run) { return energy_of(run.store); });
}

std::vector<SeamState> LiveScene::seams() {
  return visit([this](auto& run) { return seam_states(seams_as_read_, sewing_, run.store); });
}

std::vector<HandleState> LiveScene::handles() {
  return visit([](auto& run) { return handle_states(run.store); });
}

std::int64_t LiveScene::open_seam_pairs() const {
  return std::count(sewing_.welded.begin(), sewing_.welded.end(), static_cast<unsigned char>(0));
}

std::optional<double> LiveScene::limit_excess() {
  return visit([](auto& run) -> std::optional<double> {
    const Model& model = run.store.model();
    if (!has_limits(model.laws->rows)) return {};
    return largest_limit_excess(model, cast_all<double>(run.store.snapshot().positions));
  });
}

void LiveScene::count_rest() {
  visit([this](auto& run) {
    const auto snapshot = run.store.snapshot();
    const std::size_t cloth = snapshot.velocities.size();
    rest_.add_frame(Span(snapshot.positions.data(), cloth), Span(snapshot.velocities.data(), cloth),
                    snapshot.time, quiet_frames_of_rest(scene_.time));
  });
}

void LiveScene::apply_forces() {
  const std::vector<Vec3<double>> forces = live_.forces(scene_);
  visit([&](auto& run) { run.store.apply_forces(forces); });
}

void LiveScene::make_run() {
  if (scene_.precision == Precision::single_precision)
    run_ = std::make_unique<Run<float>>(scene_, devices_, sewing_);
  else
    run_ = std::make_unique<Run<double>>(scene_, devices_, sewing_);
  visit([this](auto& run) { run.store.set_compression(adaptive_.compression); });
  apply_forces();
}

/// Makes model and stores again, of a scene that has changed in what they hold.
void LiveScene::remake_run() {
  visit_current([this]<class T>(std::unique_ptr<Run<T>>& current) {
    auto next = std::make_unique<Run<T>>(scene_, devices_, sewing_, current.get());
    next->store.set_compression(adaptive_.compression);
    next->store.restore(current->store.snapshot());
    current = std::move(next);
  });
  apply_forces();
}

double LiveScene::sew(bool frame_ends, StepReport& report) {
  double changed = 0;
  if (!sewing_.welded.empty() && !sewing_.complete())
    changed = visit_current([&](auto& current) { return sew(current, frame_ends, report); });
  if (weightless_ && !sewing_.complete() && time() >= end_of_pull())
    changed += visit_current([this](auto& current) {
      return weld(current, weld_open_pairs(current->store, sewing_, [this] { go_on(); }));
    });
  update_closing_times(frame_ends);
  return changed + let_fall();
}

bool LiveScene::may_stop_sewing() {
  if (devices_.stop_flag() == nullptr || !weightless_ || sewing_.complete()) return false;
  return end_of_pull() <= visit([this](auto& run) {
           return clock_.latest_end(run.store.step_number + 1, run.store.time, run.store.next_step);
         });
}

void LiveScene::undo_step(const std::string& checkpoint) {
  const RestCount rest = rest_;
  resume(CheckpointReader(checkpoint, "state"), true);
  rest_ = rest;
}

double LiveScene::weld_share_at_frame_end() {
  const int frame = frame_number();
  if (frame % frames_per_straggler == 0 || frame >= scene_.time.frames ||
      scene_.time.until == RunUntil::rest)
    return 0;
  return weld_share_of_open * static_cast<double>(open_seam_pairs()) /
         static_cast<double>(sewing_.welded.size());
}

template <class T>
double LiveScene::sew(std::unique_ptr<Run<T>>& current, bool frame_ends, StepReport& report) {
  if (frame_ends) sewing_.refused.clear();
  return weld(current,
              weld_close_pairs(current->store, *current->implicit, sewing_,
                               frame_ends ? weld_share_at_frame_end() : weld_share, report));
}

/// @return [J] change of the cloth's energy
template <class T>
double LiveScene::weld(std::unique_ptr<Run<T>>& current, Welding<T> welding) {
  Store<T>& store = current->store;
  sewing_.refused = std::move(welding.refused);
  if (!welding.state) return 0;
  const double before = energy_of(store).total();
  sewing_.welded = std::move(welding.welded);
  // The store refers to the scene, which may be refined now; its model stays as it was.
  const auto levels = refine_if_sewn();
  auto next = std::make_unique<Run<T>>(scene_, devices_, sewing_, current.get());
  next->store.restore(transferred(store.model(), *welding.state, levels, next->store.model()));
  current = std::move(next);
  apply_forces();
  return energy_of(current->store).total() - before;
}

void LiveScene::update_closing_times(bool frame_ends) {
  visit([&](auto& run) {
    weft::update_closing_times(seams_as_read_, run.store, frame_ends, sewing_);
  });
}

/// Refines a scene that has been sewn, if that is what it asks for.
/// @return for each level the parents of its inputs, see refine_cloths()
std::vector<std::vector<std::array<Index, 2>>> LiveScene::refine_if_sewn() {
  std::vector<std::vector<std::array<Index, 2>>> levels;
  if (scene_.refinement.when != Refinement::When::sewn || !sewing_.complete() || sewing_.refined)
    return levels;
  for (int level = 0; level < scene_.refinement.levels; ++level) {
    RefinedScene finer = refine_cloths(scene_, joined_inputs(scene_, sewing_.welded));
    scene_ = std::move(finer.scene);
    levels.push_back(std::move(finer.parents));
    sewing_.welded.assign(seam_pairs(scene_).size(), 1);
  }
  sewing_.refined = true;
  return levels;
}

RemeshReport LiveScene::remesh() {
  return visit_current(
      [this](auto& current) { return remesh_step(scene_, sewing_, adaptive_, devices_, current); });
}

void LiveScene::begin_program_frame(double seconds) {
  const double now = time();
  live_.begin_frame(now, clock_.begin_program_frame(seconds, now, step_number()));
}

void LiveScene::move(ObstacleId obstacle, Span<const Vec3<double>> places) {
  live_.move(scene_, obstacle, places);
  restart_rest();
}

void LiveScene::move(PinId pin, Span<const Vec3<double>> places) {
  if (live_.move(scene_, pin, places)) remake_run();
  restart_rest();
}

void LiveScene::release(PinId pin) {
  refuse_foreign(scene_, pin, scene_.pins.size(), "pins");
  Pin& released = scene_.pins[at(pin.index)];
  released.release_time = std::min(released.release_time, time());
  wake_all();
  restart_rest();
}

void LiveScene::set_gravity(const Vec3<double>& gravity) {
  Checker(scene_.file, {}).within("gravity", gravity, quantity::acceleration);
  weightless_ = false;
  if (gravity == scene_.gravity) return;
  scene_.gravity = gravity;
  wake_all();
  restart_rest();
  // Near their limits, materials stiffen by what the cloth weighs.
  if (visit([](auto& run) { return has_limits(run.store.model().laws->rows); })) remake_run();
}

void LiveScene::set_forces(ClothId cloth, Span<const Vec3<double>> forces) {
  live_.set_forces(scene_, cloth, forces);
  apply_forces();
  restart_rest();
}

void LiveScene::set_wind(const Wind& wind) {
  const Wind before = std::exchange(scene_.wind, wind);
  try {
    validate_wind(scene_);
    validate_methods(scene_);
  } catch (...) {
    scene_.wind = before;
    throw;
  }
  // Its buffers are made where air moves.
  if ((before.density > 0 || before.drag > 0) != (wind.density > 0 || wind.drag > 0)) remake_run();
  wake_all();
  restart_rest();
}

/// Steps notice by themselves only what changes with time.
void LiveScene::wake_all() {
  if (!(scene_.implicit.sleep_distance > 0)) return;
  visit([](auto& run) {
    auto state = run.store.snapshot();
    state.sleep.causes = {};  // not those of any scene, so that everything wakes
    run.store.restore(state);
  });
}

std::string LiveScene::checkpoint() {
  Sewing sewing = sewing_;
  if (sewing.refined) sewing.welded.assign(pairs_as_read_, 1);
  const std::string adaptive = is_adaptive() ? adaptive_bytes(scene_, adaptive_) : std::string();
  const std::string live = live_bytes();
  return visit([&](auto& run) {
    return checkpoint_bytes(scene_, run.store.model(), run.store.snapshot(), sewing, adaptive, live,
                            fingerprint_, rest_.quiet_frames());
  });
}

std::vector<std::string> LiveScene::differences(const CheckpointReader& in) const {
  return differences_between(read_fingerprint(in), fingerprint_);
}

void LiveScene::resume(const CheckpointReader& in, bool same_scene) {
  QuietFrames quiet = read_quiet_frames(in);
  take_up(in);
  weightless_ = sewn_gravity_ && !sewing_.complete() && scene_.gravity == Vec3<double>{0, 0, 0};
  restart_rest();
  // Runs write checkpoints at the end of a frame.
  visit([&](auto& run) {
    const auto snapshot = run.store.snapshot();
    const std::size_t cloth = snapshot.velocities.size();
    rest_.begin_frame(Span(snapshot.positions.data(), cloth), snapshot.time);
    if (same_scene && scene_.time.until == RunUntil::rest && quiet.since.size() == cloth)
      rest_.restore(std::move(quiet), quiet_frames_of_rest(scene_.time));
  });
}

/// Makes scene, topology, inputs and state those of a checkpoint.
void LiveScene::take_up(const CheckpointReader& in) {
  const Sewing to = read_sewing(in, pairs_as_read_, seams_as_read_.size());
  const std::string inputs = read_live(in);
  // Another one than this scene's if other cloths were there, or none was chosen.
  const Vec3<double> origin = read_origin(in);
  if (to == sewing_ && !to.refined && !is_adaptive() && origin == origin_of(scene_) &&
      inputs.empty() && live_bytes().empty()) {
    load(in, true);
    return;
  }
  // If the checkpoint turns out not to fit, everything has to be as it was. The scene stays where
  // it is: the program may hold Simulation::scene().
  auto before = std::tuple(scene_, sewing_, adaptive_, live_, clock_);
  Runs run_before = std::move(run_);
  try {
    move_origin(scene_, origin);
    if (is_adaptive()) read_adaptive_bytes(read_adaptive(in), in.name(), scene_, adaptive_);
    sew_as(to, origin);
    const bool counted = set_live(inputs, in.name());
    make_run();
    load(in, counted);
  } catch (...) {
    std::tie(scene_, sewing_, adaptive_, live_, clock_) = std::move(before);
    run_ = std::move(run_before);
    throw;
  }
}

/// @param counted whether the checkpoint's time is counted, see FrameClock::counts()
void LiveScene::load(const CheckpointReader& in, bool counted) {
  visit([&](auto& run) {
    auto state = run.store.snapshot();
    read_checkpoint(in, scene_, run.store.model(), state);
    if (counted) {
      const auto [time, steps] = clock_.renumbered(state.time, state.step_number, in.name());
      state.time = time;
      if (steps != state.step_number) state.sleep = {};  // which counts steps too
      state.step_number = steps;
    }
    run.store.restore(state);
  });
}

/// Makes scene and topology those of a run that has come as far as `to`.
/// @param origin of that run
void LiveScene::sew_as(const Sewing& to, const Vec3<double>& origin) {
  if (scene_.refinement.when != Refinement::When::never) scene_ = as_read_;
  move_origin(scene_, origin);
  sewing_ = to;
  if (to.refined) {
    sewing_.refined = false;
    refine_if_sewn();
  }
}

/// What a program has set, for a checkpoint; empty: nothing.
std::string LiveScene::live_bytes() {
  const std::string bytes = live_.bytes(scene_);
  if (bytes.empty() && !clock_.in_program_frame() && counts()) return {};
  Packer packer;
  clock_.pack(packer, counts());
  return packer.bytes + bytes;
}

/// Sets what a program had set when it wrote a checkpoint.
/// @param bytes of live_bytes()
/// @return whether the checkpoint's time is counted, see FrameClock::counts()
bool LiveScene::set_live(const std::string& bytes, const std::string& file) {
  clock_.end_program_frame();
  if (bytes.empty()) {
    live_.read({}, file, scene_);
    return true;
  }
  const std::string head = bytes.substr(0, FrameClock::packed_size());
  Unpacker unpacker(head, file, "checkpoint live", "what the program had set");
  const bool counted = clock_.unpack(unpacker);
  live_.read(bytes.substr(head.size()), file, scene_);
  return counted;
}

}  // namespace weft
