#include "weft/simulation.hpp"

#include <atomic>
#include <chrono>
#include <memory>
#include <new>
#include <span>
#include <stdexcept>
#include <stop_token>
#include <string>
#include <utility>

#include "host/implicit/linear/pipelined_solve.hpp"
#include "host/scene/defaults.hpp"
#include "host/scene/origin.hpp"
#include "host/scene/part_check.hpp"
#include "host/simulation/device_choice.hpp"
#include "host/simulation/displaced_obstacles.hpp"
#include "host/simulation/live_scene.hpp"
#include "host/simulation/single_user.hpp"
#include "host/state/progress_board.hpp"
#include "weft/core/at.hpp"
#include "weft/error.hpp"

namespace weft {
namespace {

/// Pairs of seams are welded at the end of every so many steps, and of every frame. Each welding
/// makes a new model and store; with one in every fourth step, the tube of scenes/README.md around
/// a moving body stays open.
constexpr std::int64_t weld_interval = 2;

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

/// @throws DeviceError unless there is a device
DeviceSet not_empty(DeviceSet devices) {
  if (devices.size() < 1)
    throw DeviceError(
        "devices: none; allowed: at least one, in a set that no other simulation has been given");
  return devices;
}

}  // namespace

std::string AdvanceResult::message() const {
  if (failure == Failure::none) return {};
  return detail.empty() ? describe(failure) : describe(failure) + (": " + detail);
}

struct Simulation::Implementation {
  DeviceSet devices;
  LiveScene live;
  ProgressBoard board;
  SingleUser user;
  std::vector<std::vector<Vec3<float>>> places;  ///< [cloths] what positions() has given out
  bool torn = false;  ///< a step has ended with an exception: there is no state to go on from

  Implementation(Scene scene, DeviceSet d)
      : devices(not_empty(std::move(d))), live(std::move(scene), devices) {}

  /// The scene and its run while one thread uses it.
  struct Alone {
    const SingleUser::Use use;
    LiveScene& live;
    LiveScene* operator->() const { return &live; }
  };
  Alone alone() { return {SingleUser::Use(user), live}; }

  StepReport step();

  std::vector<std::string> resume(const CheckpointReader& in, SceneChanges changes) {
    std::vector<std::string> differences = live.differences(in);
    if (changes == SceneChanges::refuse) refuse_differences(differences, in.name());
    live.resume(in, differences.empty());
    torn = false;
    return differences;
  }
};

Simulation::Simulation(Scene scene, DeviceSet devices)
    : implementation_(std::make_unique<Implementation>(std::move(scene), std::move(devices))) {}
Simulation::Simulation(Scene scene, AutoDevice) {
  fill_in_defaults(scene);
  validate(scene);
  DeviceSet devices = parse_devices(choose_devices(scene).device);
  implementation_ = std::make_unique<Implementation>(std::move(scene), std::move(devices));
}
Simulation::~Simulation() = default;
Simulation::Simulation(Simulation&&) noexcept = default;
Simulation& Simulation::operator=(Simulation&&) noexcept = default;

const Scene& Simulation::scene() const {
  return implementation_->live.scene();
}
Vec3<double> Simulation::origin() const {
  return origin_of(scene());
}
int Simulation::steps_per_frame() const {
  return implementation_->live.clock().steps_per_frame();
}
double Simulation::step_length() const {
  return implementation_->alone()->step_length();
}

StepReport Simulation::Implementation::step() {
  const ShownStep shown(board, live.step_number() + 1);
  const std::string undone = live.may_stop_sewing() ? live.checkpoint() : std::string();
  StepReport report = live.visit([&](auto& run) {
    StepReport r;
    r.number = run.store.step_number + 1;
    run.step(live.clock(), r, board);
    if (r.failure == Failure::none) run.store.step_number = r.number;
    r.time = run.store.time;
    return r;
  });
  if (report.failure == Failure::none) {
    const bool frame_ends = live.at_frame_end();
    if (frame_ends) board.enter(StepStage::remeshing);
    double changed = 0;
    try {
      if (frame_ends || report.number % weld_interval == 0) changed += live.sew(frame_ends, report);
    } catch (const StoppedError&) {
      live.undo_step(undone);
      report.failure = Failure::stopped;
      report.time = live.time();
      report.open_seam_pairs = live.open_seam_pairs();
      return report;
    }
    if (frame_ends && remeshes(live.scene())) {
      const double before = live.energy().total();
      report.remesh = live.remesh();
      // Nothing gives cloth what it gains by resisting more of its compression.
      changed += live.energy().total() - before - report.remesh.compression_jump;
    }
    if (report.work) *report.work += changed;
    if (frame_ends) report.limit_excess = live.limit_excess();
    if (frame_ends && live.scene().time.until == RunUntil::rest) {
      live.count_rest();
      report.moving_share = live.rest().moving_share;
    }
  }
  if (report.failure_place) *report.failure_place += origin_of(live.scene());
  report.open_seam_pairs = live.open_seam_pairs();
  return report;
}

StepReport Simulation::step() {
  const SingleUser::Use alone(implementation_->user);
  if (implementation_->torn)
    throw std::logic_error(
        "an earlier step ran out of memory or lost a device; allowed: restore() or resume() first");
  try {
    return implementation_->step();
  } catch (const std::bad_alloc&) {
    implementation_->torn = true;
    throw;
  } catch (const DeviceError&) {
    implementation_->torn = true;
    throw;
  }
}

StepProgress Simulation::progress() const noexcept {
  return implementation_->board.read();
}

std::int64_t Simulation::step_number() const {
  return implementation_->alone()->step_number();
}

double Simulation::time() const {
  return implementation_->alone()->time();
}

int Simulation::frame_number() const {
  return implementation_->alone()->frame_number();
}

bool Simulation::at_frame_end() const {
  return implementation_->alone()->at_frame_end();
}

RestState Simulation::rest() const {
  return implementation_->live.rest();
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
  return implementation_->alone()->visit([this](auto& run) {
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
  return implementation_->alone()->energy();
}

std::vector<SeamState> Simulation::seams() const {
  return implementation_->alone()->seams();
}

std::vector<HandleState> Simulation::handles() const {
  return implementation_->alone()->handles();
}

std::uint64_t Simulation::state_hash() const {
  return implementation_->alone()->visit(
      [](auto& run) { return hash_state(run.store.model(), run.store.snapshot()); });
}

AdvanceResult Simulation::advance(double seconds, const AdvanceOptions& options) {
  const SingleUser::Use alone(implementation_->user);
  const auto start = std::chrono::steady_clock::now();
  LiveScene& live = implementation_->live;
  if (!live.clock().in_program_frame()) live.begin_program_frame(seconds);
  std::atomic<bool> stop{false};
  const std::stop_callback listen(options.stop, [&stop] { stop = true; });
  const StopFlag flag(implementation_->devices, options.stop.stop_possible() ? &stop : nullptr);
  AdvanceResult result;
  do {
    StepReport report = step();
    const bool failed = report.failure != Failure::none;
    if (!failed) {
      ++result.steps;
      result.complete = live.clock().program_frame_ended(live.time(), live.step_number());
      if (result.complete) live.clock().end_program_frame();
    }
    // It may throw: the frame has ended by then if this was its last step.
    if (options.after_step) options.after_step(report);
    if (failed) {
      result.failure = report.failure;
      result.detail = std::move(report.failure_detail);
      return result;
    }
  } while (!result.complete &&
           !(options.budget && std::chrono::steady_clock::now() - start >= *options.budget));
  return result;
}

void Simulation::move(ObstacleId obstacle, std::span<const Vec3<double>> places) {
  implementation_->alone()->move(obstacle, {places.data(), places.size()});
}

void Simulation::move(PinId pin, std::span<const Vec3<double>> places) {
  implementation_->alone()->move(pin, {places.data(), places.size()});
}

void Simulation::release(PinId pin) {
  implementation_->alone()->release(pin);
}

void Simulation::set_gravity(const Vec3<double>& gravity) {
  implementation_->alone()->set_gravity(gravity);
}

void Simulation::set_forces(ClothId cloth, std::span<const Vec3<double>> forces) {
  implementation_->alone()->set_forces(cloth, {forces.data(), forces.size()});
}

void Simulation::set_wind(const Wind& wind) {
  implementation_->alone()->set_wind(wind);
}

std::span<const Vec3<float>> Simulation::positions(ClothId cloth) {
  const SingleUser::Use alone(implementation_->user);
  Implementation& i = *implementation_;
  refuse_foreign(scene(), cloth, scene().cloths.size(), "cloths");
  i.places.resize(scene().cloths.size());
  std::vector<Vec3<float>>& places = i.places[at(cloth.index)];
  i.live.visit([&](auto& run) { run.positions.download(at(cloth.index), origin(), places); });
  return places;
}

DevicePositions Simulation::device_positions(ClothId cloth, void* stream) {
  const SingleUser::Use alone(implementation_->user);
  Implementation& i = *implementation_;
  refuse_foreign(scene(), cloth, scene().cloths.size(), "cloths");
  return i.live.visit(
      [&](auto& run) { return run.positions.on_device(at(cloth.index), origin(), stream); });
}

Transport Simulation::transport() const {
  return choose_transport(scene().solver, implementation_->devices);
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

std::string Simulation::state() const {
  return implementation_->alone()->checkpoint();
}

void Simulation::save(const std::filesystem::path& file, bool synced) const {
  write_file_atomically(file, state(), synced ? Durability::fsync : Durability::none);
}

std::vector<std::string> Simulation::restore(const std::string& state, SceneChanges changes) {
  const SingleUser::Use alone(implementation_->user);
  return implementation_->resume(CheckpointReader(state, "state"), changes);
}

std::vector<std::string> Simulation::resume(const std::filesystem::path& file,
                                            SceneChanges changes) {
  const SingleUser::Use alone(implementation_->user);
  return implementation_->resume(CheckpointReader(file), changes);
}

}  // namespace weft
