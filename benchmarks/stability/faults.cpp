// The machine fails: no memory, no room on the disk.
#include <fmt/format.h>
#include <signal.h>
#include <sys/resource.h>

#include <atomic>
#include <filesystem>
#include <memory>
#include <utility>
#include <vector>

#include "benchmarks/stability/isolate.hpp"
#include "benchmarks/stability/run.hpp"
#include "weft/error.hpp"

namespace weft::stability {
namespace {

/// A device whose memory ends after some number of allocations.
class FailingDevice final : public Device {
 public:
  /// @param left how many allocations succeed, shared by all ranks
  FailingDevice(std::shared_ptr<const DeviceSet> real, int rank,
                std::shared_ptr<std::atomic<std::int64_t>> left)
      : real_(std::move(real)), device_((*real_)[rank]), left_(std::move(left)) {}
  Backend backend() const noexcept override { return device_.backend(); }
  std::string name() const override { return device_.name(); }
  Queue& compute() noexcept override { return device_.compute(); }
  Queue& transfer() noexcept override { return device_.transfer(); }
  void* allocate(std::size_t bytes) override {
    if (left_->fetch_sub(1) <= 0) throw DeviceError("out of memory: injected");
    return device_.allocate(bytes);
  }
  void release(void* memory, std::size_t bytes) noexcept override {
    device_.release(memory, bytes);
  }
  std::size_t peak_bytes() const noexcept override { return device_.peak_bytes(); }
  std::int64_t allocation_count() const noexcept override { return device_.allocation_count(); }
  bool reaches_peers() const noexcept override { return device_.reaches_peers(); }

 private:
  std::shared_ptr<const DeviceSet> real_;  ///< outlives the device
  Device& device_;
  std::shared_ptr<std::atomic<std::int64_t>> left_;
};

Scene small_scene(const Setup& setup) {
  Scene scene = sheet_on_sphere(setup, 0.005);
  jitter(scene, setup);
  return scene;
}

constexpr int run_steps = 10;

/// Runs with memory that ends after `allocations`.
/// @return what was left
std::int64_t run_with(const Setup& setup, std::int64_t allocations) {
  const auto left = std::make_shared<std::atomic<std::int64_t>>(allocations);
  Run run(small_scene(setup), [&] {
    const auto real = std::make_shared<const DeviceSet>(parse_devices(setup.device));
    std::vector<std::unique_ptr<Device>> failing;
    for (int r = 0; r < real->size(); ++r)
      failing.push_back(std::make_unique<FailingDevice>(real, r, left));
    return DeviceSet(std::move(failing));
  });
  run.watch(run_steps);
  return *left;
}

/// Memory ends at the first allocation, the second, and so on in growing strides.
void out_of_memory(const Setup& setup) {
  constexpr std::int64_t plenty = 1'000'000'000;
  const std::int64_t needed = plenty - run_with(setup, plenty);
  std::int64_t refusals = 0;
  for (std::int64_t n = 0; n < needed; n += 1 + n / 4) {
    try {
      run_with(setup, n);
    } catch (const DeviceError&) {
      ++refusals;
      continue;
    }
    throw Wrong(fmt::format("allocation {} of {} failed, and nobody noticed", n + 1, needed));
  }
  throw DeviceError(fmt::format("{} runs whose memory ended, all refused", refusals));
}

/// No file may grow beyond `bytes` in this process while this is there.
class FullDisk {
 public:
  explicit FullDisk(std::size_t bytes) {
    ::signal(SIGXFSZ, SIG_IGN);
    ::getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    if (::setrlimit(RLIMIT_FSIZE, &limit) != 0) throw Wrong("cannot limit the size of files");
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;
  ~FullDisk() { ::setrlimit(RLIMIT_FSIZE, &before_); }

 private:
  rlimit before_{};
};

/// @return what `write` is refused with on a full disk
template <class Write>
std::string refusal_of(const Write& write) {
  const FullDisk disk(1000);
  try {
    write();
  } catch (const SceneError& error) {
    return error.what();
  } catch (const std::filesystem::filesystem_error& error) {
    return error.what();
  }
  throw Wrong("a checkpoint that did not fit was not refused");
}

/// A refusal without the name of the file, which is another one each time.
[[noreturn]] void refuse_as(const std::string& refusal) {
  const auto colon = refusal.find(": ");
  throw SceneError("checkpoint" + (colon == std::string::npos ? "" : refusal.substr(colon)));
}

/// Slices that find no room on the disk are gone on with once there is some.
void full_disk_of_slices(const Setup& setup) {
  const auto folder = scratch_folder() / "full_disk";
  const std::string refusal =
      refusal_of([&] { start(small_scene(setup), setup).watch(run_steps, run_steps, {}, folder); });
  Run later = start(small_scene(setup), setup);
  later.watch(run_steps, run_steps, {}, folder);
  if (later.now().state_hash() != run(small_scene(setup), setup, run_steps).now().state_hash())
    throw Wrong("a run that was gone on with ended elsewhere");
  refuse_as(refusal);
}

/// A checkpoint that does not fit: the old one stays, whole.
/// @pre runs in a process of its own
void full_disk(const Setup& setup) {
  if (setup.method == "time_parallel") return full_disk_of_slices(setup);
  const auto file = scratch_folder() / "full_disk.weft";
  Run simulation = start(small_scene(setup), setup);
  simulation.watch(5);
  simulation.now().save(file);
  const std::uint64_t saved = simulation.now().state_hash();
  simulation.watch(5);
  const std::string refusal = refusal_of([&] { simulation.now().save(file); });
  Run other = start(small_scene(setup), setup);
  other.resume(file);
  if (other.now().state_hash() != saved) throw Wrong("the old checkpoint is not as it was");
  simulation.watch(5);  // goes on all the same
  refuse_as(refusal);
}

}  // namespace

std::vector<Case> fault_cases() {
  return {
      {"out_of_memory", "each allocation fails in turn: refused, and nothing is left behind",
       out_of_memory},
      {"full_disk", "a checkpoint does not fit: refused, the old one is whole, the run goes on",
       full_disk},
  };
}

}  // namespace weft::stability
