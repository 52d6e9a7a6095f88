#include "weft/simulation.hpp"

#include <algorithm>
#include <cmath>
#include <variant>

#include "host/implicit/step.hpp"
#include "host/scene/checkpoint.hpp"
#include "host/scene/energy.hpp"
#include "host/scene/tangle.hpp"
#include "weft/error.hpp"

namespace weft {
namespace {

/// State and method in one precision.
template <class T>
struct Run {
  Store<T> store;
  ImplicitStep<T> implicit;

  Run(const Scene& scene, DeviceSet& devices) : store(scene, devices), implicit(store) {}
};

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
  }
  return "unknown";
}

struct Simulation::Implementation {
  Scene scene;
  DeviceSet devices;
  int steps_per_frame;
  std::variant<std::monostate, std::unique_ptr<Run<float>>, std::unique_ptr<Run<double>>> run;

  template <class Use>
  auto visit(Use use) {
    if (auto* single = std::get_if<1>(&run)) return use(**single);
    return use(**std::get_if<2>(&run));
  }

  Implementation(Scene s, DeviceSet d) : scene(std::move(s)), devices(std::move(d)) {
    refuse_tangled_start(scene);
    if (scene.method != "implicit")
      throw SceneError(scene.file, "method.type", "\"" + scene.method + "\"", "implicit");
    if (!scene.handles.empty())
      throw SceneError(scene.file, "handles", std::to_string(scene.handles.size()) + " handles",
                       "none: handles other than pins are not simulated yet");
    if (!scene.seams.empty())
      throw SceneError(scene.file, "seams", std::to_string(scene.seams.size()) + " seams",
                       "none: seams are not simulated yet");
    // A frame that takes a hair more than a whole number of steps takes that number.
    const double steps = 1 / (scene.time.frame_rate * scene.time.step);
    steps_per_frame = std::max(1, static_cast<int>(std::ceil(steps * (1 - 1e-9))));
    if (devices.backend() != Backend::host)
      throw DeviceError("the implicit step does not run on CUDA yet; use --device cpu");
    if (scene.precision == Precision::single_precision)
      run = std::make_unique<Run<float>>(scene, devices);
    else
      run = std::make_unique<Run<double>>(scene, devices);
  }

  double step_length() const { return 1 / (scene.time.frame_rate * steps_per_frame); }
};

Simulation::Simulation(Scene scene, DeviceSet devices)
    : implementation_(std::make_unique<Implementation>(std::move(scene), std::move(devices))) {}
Simulation::~Simulation() = default;
Simulation::Simulation(Simulation&&) noexcept = default;
Simulation& Simulation::operator=(Simulation&&) noexcept = default;

const Scene& Simulation::scene() const {
  return implementation_->scene;
}
int Simulation::steps_per_frame() const {
  return implementation_->steps_per_frame;
}
double Simulation::step_length() const {
  return implementation_->step_length();
}

StepReport Simulation::step() {
  return implementation_->visit([this](auto& run) {
    StepReport report;
    report.number = run.store.step_number + 1;
    report.step = step_length();
    run.implicit.advance(step_length(), report);
    if (report.failure == Failure::none) {
      run.store.step_number = report.number;
      // Counted, not summed up, so that a resumed run sees the same times.
      run.store.time = static_cast<double>(report.number) * step_length();
    }
    report.time = run.store.time;
    return report;
  });
}

std::int64_t Simulation::step_number() const {
  return implementation_->visit([](auto& run) { return run.store.step_number; });
}

double Simulation::time() const {
  return implementation_->visit([](auto& run) { return run.store.time; });
}

int Simulation::frame_number() const {
  return static_cast<int>(step_number() / steps_per_frame());
}

Frame Simulation::frame() const {
  return implementation_->visit([this](auto& run) {
    const Model& model = run.store.model();
    const Scene& s = scene();
    const auto snapshot = run.store.snapshot();
    Frame frame;
    frame.number = frame_number();
    frame.time = snapshot.time;
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
    return frame;
  });
}

Energy Simulation::energy() const {
  return implementation_->visit([this](auto& run) {
    const auto snapshot = run.store.snapshot();
    return measure_energy(scene(), run.store.model(), cast_all<double>(snapshot.positions),
                          cast_all<double>(snapshot.velocities));
  });
}

std::uint64_t Simulation::state_hash() const {
  return implementation_->visit(
      [](auto& run) { return hash_state(run.store.model(), run.store.snapshot()); });
}

std::vector<std::size_t> Simulation::peak_device_bytes() const {
  std::vector<std::size_t> bytes;
  for (int r = 0; r < implementation_->devices.size(); ++r)
    bytes.push_back(implementation_->devices[r].peak_bytes());
  return bytes;
}

void Simulation::save(const std::filesystem::path& file) const {
  implementation_->visit(
      [&](auto& run) { write_checkpoint(file, scene(), run.store.model(), run.store.snapshot()); });
}

void Simulation::resume(const std::filesystem::path& file) {
  implementation_->visit([&](auto& run) {
    auto snapshot = run.store.snapshot();
    read_checkpoint(file, scene(), run.store.model(), snapshot);
    run.store.restore(snapshot);
  });
}

}  // namespace weft
