// Every kernel of the implicit step on real data: the bytes that it cannot do without, the time
// that a copy of as many would take (its floor), and the time that it took. The scene runs to an
// instant, then for some steps with a clock around each launch.
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "benchmarks/support/bench_main.hpp"
#include "benchmarks/support/kernel_bytes.hpp"
#include "benchmarks/support/queue_clock.hpp"
#include "benchmarks/support/scene_settings.hpp"
#include "host/base/atomic_file.hpp"
#include "host/io/scene/scene_file.hpp"
#include "weft/devices.hpp"
#include "weft/error.hpp"
#include "weft/exec/buffer.hpp"
#include "weft/simulation.hpp"

namespace {

using Json = nlohmann::ordered_json;

struct Options {
  std::string scene = WEFT_SOURCE_DIR "/scenes/sphere.json";
  std::string device = "cpu:1";
  std::vector<std::string> overrides;
  double at = 0.75;
  int steps = 10;
  std::string json;
  bool smoke = false;
};

/// What all launches of a kernel came to.
struct KernelSum {
  std::int64_t launches = 0;
  double bytes = 0;
  double seconds = 0;
  bool counted = true;  ///< its bytes are known
};

/// A clock around each launch of this thread while it watches.
class KernelClock final : public weft::LaunchObserver {
 public:
  explicit KernelClock(weft::Index cloth_vertices) : bytes_(cloth_vertices) {}
  ~KernelClock() override { current = nullptr; }
  KernelClock(const KernelClock&) = delete;
  KernelClock& operator=(const KernelClock&) = delete;

  void watch(bool on) { current = on ? this : nullptr; }
  void before(weft::Queue& queue) override { clock_.start(queue); }
  void after(weft::Queue& queue, const std::type_info& kernel, const void* args) override {
    const double seconds = clock_.stop(queue);
    const auto launch = bytes_(queue, kernel, args);
    // Not worth a line: nothing to do in this scene.
    if (launch && launch->bytes == 0) return;
    KernelSum& sum = sums_[launch ? launch->name : kernel.name()];
    ++sum.launches;
    sum.seconds += seconds;
    sum.counted = launch.has_value();
    if (launch) sum.bytes += launch->bytes;
  }
  const std::map<std::string, KernelSum>& sums() const { return sums_; }

 private:
  weft::bench::KernelBytes bytes_;
  weft::bench::QueueClock clock_;
  std::map<std::string, KernelSum> sums_;
};

/// What the device's memory and its launches can do at best.
struct Limits {
  double copy = 0;    ///< [B/s] read and written by a copy within its memory, best of some
  double launch = 0;  ///< [s] between two events around next to nothing, median
};

Limits measure_limits(const std::string& device, std::size_t bytes) {
  weft::DeviceSet devices = weft::parse_devices(device);
  weft::Queue& queue = devices[0].compute();
  const weft::Buffer<unsigned char> from(devices[0], bytes), to(devices[0], bytes);
  queue.fill(from.data(), 1, bytes);
  weft::bench::QueueClock clock;
  Limits limits;
  std::vector<double> launches;
  for (int repeat = 0; repeat < 12; ++repeat) {
    clock.start(queue);
    queue.copy(to.data(), from.data(), bytes);
    limits.copy = std::max(limits.copy, 2 * static_cast<double>(bytes) / clock.stop(queue));
    clock.start(queue);
    queue.fill(to.data(), 0, 4);
    launches.push_back(clock.stop(queue));
  }
  std::sort(launches.begin(), launches.end());
  limits.launch = launches[launches.size() / 2];
  return limits;
}

/// What the timed steps were like.
struct StepSums {
  double unobserved = 0;    ///< [s] of a step without clocks, mean of as many in between
  weft::StageTimes stages;  ///< [s] a step, of those
  std::int64_t iterations = 0, solves = 0, searches = 0, zone_rounds = 0;
  std::int64_t pairs = 0, contacts = 0;  ///< most in a step
};

weft::StepReport step(weft::Simulation& simulation) {
  weft::StepReport report = simulation.step();
  if (report.failure != weft::Failure::none)
    throw weft::SimulationError(fmt::format("step {}: {}: {}", report.number,
                                            describe(report.failure), report.failure_detail));
  return report;
}

/// Steps without clocks and steps with them, by turns, as many of each.
StepSums run_steps(weft::Simulation& simulation, const Options& options,
                   std::map<std::string, KernelSum>& kernels) {
  while (simulation.time() + 0.5 * simulation.step_length() < options.at) step(simulation);
  StepSums sums;
  std::size_t cloth = 0;
  for (const auto& positions : simulation.frame().cloth_positions) cloth += positions.size();
  KernelClock clock(static_cast<weft::Index>(cloth));
  for (int n = 0; n < options.steps; ++n) {
    const auto start = std::chrono::steady_clock::now();
    sums.stages += step(simulation).stages;
    sums.unobserved +=
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() /
        options.steps;
    clock.watch(true);
    const weft::StepReport report = step(simulation);
    clock.watch(false);
    sums.iterations += report.iterations;
    sums.solves += report.solves;
    sums.searches += report.searches;
    sums.zone_rounds += report.zone_rounds;
    sums.pairs = std::max(sums.pairs, report.face_pairs + report.edge_pairs);
    sums.contacts = std::max(sums.contacts, report.proximities);
  }
  kernels = clock.sums();
  return sums;
}

Json kernels_json(const std::map<std::string, KernelSum>& kernels, const Limits& limits,
                  int steps) {
  double all = 0;
  for (const auto& [name, sum] : kernels) all += sum.seconds;
  Json list = Json::array();
  for (const auto& [name, sum] : kernels) {
    const auto launches = static_cast<double>(sum.launches);
    const double floor = sum.bytes / launches / limits.copy;
    const double seconds = sum.seconds / launches;
    Json kernel = {{"kernel", name},
                   {"launches_per_step", launches / steps},
                   {"us", 1e6 * seconds},
                   {"bytes", nullptr},
                   {"floor_us", nullptr},
                   {"ratio", nullptr},
                   {"ms_per_step", 1e3 * sum.seconds / steps},
                   {"share", sum.seconds / all}};
    if (sum.counted) {
      kernel["bytes"] = sum.bytes / launches;
      kernel["floor_us"] = 1e6 * floor;
      kernel["ratio"] = floor > 0 ? seconds / floor : 0;
    }
    list.push_back(kernel);
  }
  std::stable_sort(list.begin(), list.end(), [](const Json& a, const Json& b) {
    return a["ms_per_step"].get<double>() > b["ms_per_step"].get<double>();
  });
  return list;
}

/// The parts that P-Cloth's figure 11 shares the time out to; the zones' own kernels handle
/// penetrations, and proximities, which the system takes for its contacts, are narrow phase.
const char* part_of(const std::string& kernel) {
  for (const char* name : {"collide/proximity", "collide/continuous"})
    if (kernel == name) return "narrow_phase";
  if (kernel.starts_with("collide/")) return "broad_phase";
  if (kernel == "respond/zones" || kernel == "respond/apply") return "penetration_handling";
  return "time_integration";
}

/// [ms] a step in kernels.
Json parts_json(const std::map<std::string, KernelSum>& kernels, int steps) {
  Json parts = {{"time_integration", 0.0},
                {"broad_phase", 0.0},
                {"narrow_phase", 0.0},
                {"penetration_handling", 0.0}};
  for (const auto& [name, sum] : kernels) {
    Json& part = parts[part_of(name)];
    part = part.get<double>() + 1e3 * sum.seconds / steps;
  }
  return parts;
}

Json steps_json(const StepSums& sums, int steps) {
  const auto mean = [steps](auto sum) { return static_cast<double>(sum) / steps; };
  return {{"steps", steps},
          {"ms_without_clocks", 1e3 * sums.unobserved},
          {"stages_ms_without_clocks",
           {{"contacts", mean(1e3 * sums.stages.contacts)},
            {"assemble", mean(1e3 * sums.stages.assemble)},
            {"solve", mean(1e3 * sums.stages.solve)},
            {"certify", mean(1e3 * sums.stages.resolve_collisions)},
            {"other", mean(1e3 * sums.stages.other)}}},
          {"iterations", mean(sums.iterations)},
          {"solves", mean(sums.solves)},
          {"searches", mean(sums.searches)},
          {"zone_rounds", mean(sums.zone_rounds)},
          {"pairs_max", sums.pairs},
          {"contacts_max", sums.contacts}};
}

/// What the rank's memory is for, and most bytes of each.
Json uses_json(const weft::Simulation& simulation) {
  Json uses = Json::object();
  const std::vector<std::vector<weft::MemoryUse>> ranks = simulation.device_memory();
  for (const weft::MemoryUse& use : ranks.front()) uses[use.name] = use.peak_bytes;
  return uses;
}

void print(const Json& kernels, const Limits& limits, const StepSums& sums) {
  fmt::print("copy {:.3f} TB/s; an empty launch {:.1f} us; a step {:.2f} ms\n\n",
             1e-12 * limits.copy, 1e6 * limits.launch, 1e3 * sums.unobserved);
  fmt::print("{:<20} {:>9} {:>10} {:>10} {:>10} {:>7} {:>9}\n", "kernel", "a step", "MB",
             "floor us", "us", "ratio", "ms/step");
  for (const Json& k : kernels) {
    const bool counted = !k["bytes"].is_null();
    fmt::print("{:<20} {:>9.1f} {:>10.3f} {:>10.1f} {:>10.1f} {:>7.2f} {:>9.3f}\n",
               k["kernel"].get<std::string>(), k["launches_per_step"].get<double>(),
               counted ? 1e-6 * k["bytes"].get<double>() : 0.0,
               counted ? k["floor_us"].get<double>() : 0.0, k["us"].get<double>(),
               counted ? k["ratio"].get<double>() : 0.0, k["ms_per_step"].get<double>());
  }
}

int run(Options options, const std::vector<std::string>& command) {
  if (options.smoke) {
    options.overrides.push_back("triangles=800");
    options.at = std::min(options.at, 0.02);
    options.steps = 2;
  }
  const weft::io::SceneFile file = weft::bench::read_scene_file(options.scene, options.overrides);
  Json machine = weft::bench::machine_json();
  machine["devices"] = weft::describe_devices();
  const Limits limits = measure_limits(options.device, std::size_t{1} << (options.smoke ? 24 : 28));
  weft::DeviceSet devices = weft::parse_devices(options.device);
  if (devices.size() != 1)
    throw weft::SceneError("", "--device", options.device, "a single rank, as in cpu:1 or cuda:0");
  weft::Simulation simulation(file.scene, std::move(devices));
  std::map<std::string, KernelSum> kernels;
  const StepSums sums = run_steps(simulation, options, kernels);
  const Json list = kernels_json(kernels, limits, options.steps);
  print(list, limits, sums);
  if (options.json.empty()) return weft::bench::done;
  std::size_t triangles = 0;
  for (const weft::Cloth& cloth : simulation.scene().cloths)
    triangles += cloth.mesh.triangles.size();
  const Json json = {{"benchmark", "roofline"},
                     {"build", weft::bench::build_json()},
                     {"command", command},
                     {"scene", file.scene.name},
                     {"triangle_count", triangles},
                     {"device", options.device},
                     {"from_s", options.at},
                     {"copy_tb_per_s", 1e-12 * limits.copy},
                     {"empty_launch_us", 1e6 * limits.launch},
                     {"step", steps_json(sums, options.steps)},
                     {"kernels", list},
                     {"parts_ms", parts_json(kernels, options.steps)},
                     {"peak_device_bytes_by_use", uses_json(simulation)},
                     {"resolved_scene", weft::bench::without_folders(file.resolved)},
                     {"machine", machine}};
  weft::write_file_atomically(options.json, json.dump(2) + "\n");
  return weft::bench::done;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Bytes, floor and time of every kernel of a step", "weft_bench_roofline");
  Options options;
  app.add_option("--scene", options.scene, "Scene file; default: scenes/sphere.json");
  app.add_option("--set", options.overrides, "Override a value of the scene; may be repeated")
      ->type_name("PATH=VALUE")
      ->allow_extra_args(false);
  app.add_option("--device", options.device, "A single rank: cpu:1 (default), cuda:0, ...");
  app.add_option("--at", options.at, "[s] simulated before anything is timed; default: 0.75")
      ->check(CLI::Range(0.0, 1e6));
  app.add_option("--steps", options.steps, "Steps that are timed; default: 10")
      ->check(CLI::Range(1, 100000));
  app.add_option("--json", options.json, "Write all figures to this file");
  app.add_flag("--smoke", options.smoke, "800 triangles, 2 steps after 0.02 s");
  return weft::bench::bench_main(app, argc, argv, [&](const std::vector<std::string>& command) {
    return run(options, command);
  });
}
