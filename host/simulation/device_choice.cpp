#include "host/simulation/device_choice.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>

#include "host/exec/device_text.hpp"
#include "host/implicit/linear/iteration_bytes.hpp"
#include "host/implicit/parallel/transfer_overhead.hpp"
#include "host/implicit/parallel/work_queues.hpp"
#include "weft/error.hpp"

namespace weft {
namespace {

/// Time of an iteration over that of a copy of the same bytes:
/// benchmarks/journal/2026-11-one-h100.md.
constexpr double bytes_excess = 1.15;
/// [s] while a GPU's blocks wait for each other, an iteration.
constexpr double barriers = 5e-6;

/// Waits for another GPU's answer that an iteration has with `peer`: rows and then a flag, sums
/// and then a flag; each is on its way for as long as a load takes, and is fenced.
constexpr double peer_waits = 4;

/// Of what it takes to issue a copy, to launch a kernel.
constexpr double launch_share = 0.5;

/// Iterations of a step: 43 to 244 in the drapes that the model is compared with.
constexpr double typical_iterations = 150;
/// [s] that an iteration with contacts and levels waits longer than one without.
constexpr double further_waits = 15e-6;
/// What a step takes beside its iterations: [s] whatever the rows, [s] for each further GPU, since
/// one thread launches for all, and as long as copies of so many bytes a row, of which GPUs share
/// half.
constexpr double step_overhead = 1.5e-3;
constexpr double overhead_of_gpu = 0.8e-3;
constexpr double step_bytes_a_row = 93e3;

/// Share of the time of a step that more GPUs have to save.
constexpr double saving_share = 1.0 / 8;

double compute_time(const ProductLoad& load, double bandwidth, double rows) {
  return rows * load.bytes_a_row * bytes_excess / bandwidth;
}

double peer_time(const ProductLoad& load, double bandwidth, int ranks, const LinkFigures& link) {
  const double halo = halo_rows(load, ranks) * load.vector_bytes / link.load_bandwidth;
  const double own = compute_time(load, bandwidth, load.rows / ranks);
  return gathered_times({{0, own}, {peer_waits * link.load_latency + halo}}).back();
}

double pipelined_time(const ProductLoad& load, double bandwidth, int ranks,
                      const LinkFigures& link) {
  const std::size_t stages = work_queues(ranks).front().size();
  const double rows = load.rows / ranks;
  const double outer = std::min(rows, halo_rows(load, ranks));
  ProductTimes times;
  times.compute.assign(stages + 1,
                       compute_time(load, bandwidth, outer / static_cast<double>(stages)));
  times.compute.front() = compute_time(load, bandwidth, rows - outer);
  // One thread issues the copies of all ranks; a stage ends when the last of them is there.
  times.transfer.assign(stages,
                        ranks * link.copy_latency + rows * load.vector_bytes / link.copy_bandwidth);
  const double sums = ranks * (ranks - 1) * link.copy_latency;
  // The same thread launches all kernels, of each rank four and a product a stage.
  const double copies = static_cast<double>(stages) * ranks + ranks * (ranks - 1);
  const double launches = ranks * (5 + static_cast<double>(stages));
  const double issued = (copies + launch_share * launches) * link.copy_latency;
  return std::max(pipelined_times(times).back() + sums, issued);
}

/// The slower of two in every way.
LinkFigures slower_of(const LinkFigures& a, const LinkFigures& b) {
  return {a.peer && b.peer, std::max(a.load_latency, b.load_latency),
          std::min(a.load_bandwidth, b.load_bandwidth), std::max(a.copy_latency, b.copy_latency),
          std::min(a.copy_bandwidth, b.copy_bandwidth)};
}

template <class... Values>
std::string formatted(const char* format, Values... values) {
  char text[200];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

std::string figures_of(const LinkFigures& link) {
  std::string text = link.peer ? formatted("loads %.2f us, %.1f GB/s; ", 1e6 * link.load_latency,
                                           1e-9 * link.load_bandwidth)
                               : std::string("no loads; ");
  return text + formatted("copies %.1f us, %.1f GB/s", 1e6 * link.copy_latency,
                          1e-9 * link.copy_bandwidth);
}

/// Figures of the first GPUs of a machine, measured as more of them are asked for.
class FirstGpus {
 public:
  explicit FirstGpus(MachineProbe& probe) : probe_(probe) {}

  double bandwidth() const { return bandwidth_; }
  const LinkFigures& link() const { return link_; }
  const std::vector<std::string>& lines() const { return lines_; }

  void measure(int count) {
    for (; gpus_ < count; ++gpus_) {
      const double own = probe_.bandwidth(gpus_);
      bandwidth_ = gpus_ == 0 ? own : std::min(bandwidth_, own);
      lines_.push_back("cuda:" + std::to_string(gpus_) + ": " + probe_.name(gpus_) +
                       formatted(", copies at %.2f TB/s", 1e-12 * own));
      for (int other = 0; other < gpus_; ++other) add_link(other);
    }
  }

 private:
  void add_link(int other) {
    const LinkFigures link = probe_.link(other, gpus_);
    link_ = gpus_ == 1 ? link : slower_of(link_, link);
    lines_.push_back("cuda:" + std::to_string(other) + " to cuda:" + std::to_string(gpus_) + ": " +
                     figures_of(link));
  }

  MachineProbe& probe_;
  int gpus_ = 0;
  double bandwidth_ = 0;
  LinkFigures link_;
  std::vector<std::string> lines_;
};

/// Why the scene does not run on GPUs unless they are named; empty: it does.
std::string reason_for_cpu(const Scene& scene) {
  if (scene.method == "asynchronous") return "the method asynchronous runs on CPU threads only";
  if (scene.method == "adaptive" || scene.method == "view")
    return "the method " + scene.method + " remeshes on the CPU";
  if (scene.method == "time_parallel") return "slices of time run on the CPU unless GPUs are named";
  if (scene.implicit.sleep_distance > 0) return "cloth that may sleep runs on CPU threads only";
  return {};
}

bool pays(double before, double after) {
  return after <= (1 - saving_share) * before;
}

/// The next number of GPUs to look at: 2, 4, 8, ..., and at last all of them.
int next_count(int count, int all) {
  return count * 2 <= all ? count * 2 : all;
}

class GpuChoice {
 public:
  GpuChoice(const Scene& scene, MachineProbe& probe)
      : load_(product_load(scene)), all_(probe.gpu_count()), gpus_(probe) {}

  DeviceChoice decide() {
    gpus_.measure(1);
    add(1, step_time(load_, gpus_.bandwidth(), 1, {}, Transport::peer), "");
    int taken = 1;
    std::string why = all_ == 1 ? "the only GPU" : "";
    while (why.empty() && taken < all_) {
      const int next = next_count(taken, all_);
      why = reason_against(next);
      if (why.empty()) taken = next;
    }
    if (why.empty()) why = "all GPUs";
    choice_.device = first_gpus_text(taken);
    choice_.reason = why;
    choice_.figures = gpus_.lines();
    return choice_;
  }

 private:
  void add(int gpus, double seconds, const char* transport) {
    choice_.estimates.push_back({gpus, transport, seconds});
  }

  /// Empty: `next` GPUs pay.
  std::string reason_against(int next) {
    const double now = choice_.estimates.back().seconds;
    const double free =
        step_time(load_, gpus_.bandwidth(), next, {true, 0, 1e300, 0, 1e300}, Transport::peer);
    if (!pays(now, free))
      return formatted(
          "%d GPUs would take %.1f ms per step instead of %.1f, even without transfers", next,
          1e3 * free, 1e3 * now);
    gpus_.measure(next);
    const bool peer = gpus_.link().peer && load_.transport != Transport::pipelined;
    if (!peer && load_.transport == Transport::peer)
      return "the GPUs cannot access each other's memory, which solver.transport requires";
    const Transport transport = peer ? Transport::peer : Transport::pipelined;
    const double after = step_time(load_, gpus_.bandwidth(), next, gpus_.link(), transport);
    add(next, after, peer ? "peer" : "pipelined");
    if (pays(now, after)) return {};
    return formatted("%d GPUs would take %.1f ms per step instead of %.1f", next, 1e3 * after,
                     1e3 * now);
  }

  ProductLoad load_;
  int all_;
  FirstGpus gpus_;
  DeviceChoice choice_;
};

DeviceChoice on_cpu(std::string reason) {
  DeviceChoice choice;
  choice.device = DeviceText{}.text();
  choice.reason = std::move(reason);
  return choice;
}

}  // namespace

ProductLoad product_load(const Scene& scene) {
  ProductLoad load;
  std::size_t vertices = 0;
  for (const Cloth& cloth : scene.cloths) vertices += cloth.mesh.positions.size();
  load.rows = static_cast<double>(vertices);
  if (scene.refinement.when != Refinement::When::never)
    load.rows *= std::pow(4.0, scene.refinement.levels);
  const bool single = scene.precision == Precision::single_precision;
  // Numbers twice as long, columns as before: of 40 bytes a block 36 are numbers.
  load.bytes_a_row = iteration_bytes(scene.solver.preconditioner) * (single ? 1 : 1.9);
  load.vector_bytes = single ? 12 : 24;
  load.contacts = scene.contact.self;
  load.transport = scene.solver.transport;
  return load;
}

double halo_rows(const ProductLoad& load, int ranks) {
  if (ranks == 1) return 0;
  const double own = load.rows / ranks;
  const double around = 8 * std::sqrt(own) + (load.contacts ? own / 2 : 0);
  return std::min(around, load.rows - own);
}

double product_time(const ProductLoad& load, double bandwidth, int ranks, const LinkFigures& link,
                    Transport transport) {
  if (ranks == 1) return barriers + compute_time(load, bandwidth, load.rows);
  return barriers + (transport == Transport::pipelined
                         ? pipelined_time(load, bandwidth, ranks, link)
                         : peer_time(load, bandwidth, ranks, link));
}

double step_time(const ProductLoad& load, double bandwidth, int ranks, const LinkFigures& link,
                 Transport transport) {
  const double iteration = product_time(load, bandwidth, ranks, link, transport) + further_waits;
  const double rows = load.rows * (1 + 1.0 / ranks) / 2;
  return typical_iterations * iteration + step_overhead + overhead_of_gpu * (ranks - 1) +
         rows * step_bytes_a_row / bandwidth;
}

DeviceChoice choose_devices(const Scene& scene, MachineProbe& probe) {
  if (std::string reason = reason_for_cpu(scene); !reason.empty()) return on_cpu(reason);
  if (probe.gpu_count() == 0) return on_cpu(probe.why_none());
  return GpuChoice(scene, probe).decide();
}

DeviceChoice look_for_devices(const Scene& scene, MachineProbe& probe) {
  try {
    return choose_devices(scene, probe);
  } catch (const DeviceError& error) {
    DeviceChoice none;
    none.reason = error.what();
    return none;
  }
}

std::vector<std::string> describe_links(MachineProbe& probe) {
  std::vector<std::string> lines;
  for (int to = 1; to < probe.gpu_count(); ++to)
    for (int from = 0; from < to; ++from)
      lines.push_back("cuda:" + std::to_string(from) + " to cuda:" + std::to_string(to) + ": " +
                      figures_of(probe.link(from, to)));
  return lines;
}

namespace {

/// Of builds without CUDA.
class NoGpus final : public MachineProbe {
 public:
  int gpu_count() override { return 0; }
  std::string why_none() override { return "this build has no CUDA"; }
  std::string name(int) override { return {}; }
  double bandwidth(int) override { return 0; }
  LinkFigures link(int, int) override { return {}; }
};

std::unique_ptr<MachineProbe> this_machine() {
#if defined(WEFT_CUDA)
  return cuda_machine_probe();
#else
  return std::make_unique<NoGpus>();
#endif
}

}  // namespace

DeviceChoice choose_devices(const Scene& scene) {
  return choose_devices(scene, *this_machine());
}

DeviceChoice look_for_devices(const Scene& scene) {
  return look_for_devices(scene, *this_machine());
}

std::vector<std::string> describe_links() {
  return describe_links(*this_machine());
}

}  // namespace weft
