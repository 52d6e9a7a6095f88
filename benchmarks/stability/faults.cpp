// The machine fails: no memory, no room on the disk.
#include <fmt/format.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <filesystem>
#include <memory>
#include <utility>
#include <vector>

#include "benchmarks/stability/run.hpp"
#include "weft/error.hpp"

namespace weft::stability {
namespace {

/// A device whose memory ends after some number of allocations.
class FailingDevice final : public Device {
 public:
  /// @param left how many allocations succeed, shared by all ranks
  FailingDevice(Device& device, std::shared_ptr<std::int64_t> left)
      : device_(device), left_(std::move(left)) {}
  Backend backend() const noexcept override { return device_.backend(); }
  std::string name() const override { return device_.name(); }
  Queue& compute() noexcept override { return device_.compute(); }
  Queue& transfer() noexcept override { return device_.transfer(); }
  void* allocate(std::size_t bytes) override {
    if (*left_ <= 0) throw DeviceError("out of memory: injected");
    --*left_;
    return device_.allocate(bytes);
  }
  void release(void* memory, std::size_t bytes) noexcept override {
    device_.release(memory, bytes);
  }
  std::size_t peak_bytes() const noexcept override { return device_.peak_bytes(); }
  std::int64_t allocation_count() const noexcept override { return device_.allocation_count(); }
  bool reaches_peers() const noexcept override { return device_.reaches_peers(); }

 private:
  Device& device_;
  std::shared_ptr<std::int64_t> left_;
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
  const DeviceSet real = parse_devices(setup.device);
  const auto left = std::make_shared<std::int64_t>(allocations);
  std::vector<std::unique_ptr<Device>> failing;
  for (int r = 0; r < real.size(); ++r)
    failing.push_back(std::make_unique<FailingDevice>(real[r], left));
  Simulation simulation(small_scene(setup), DeviceSet(std::move(failing)));
  watch(simulation, run_steps);
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

/// No file may grow beyond `bytes` in this process from now on.
void limit_files(std::size_t bytes) {
  ::signal(SIGXFSZ, SIG_IGN);
  const rlimit limit{bytes, bytes};
  if (::setrlimit(RLIMIT_FSIZE, &limit) != 0) throw Wrong("cannot limit the size of files");
}

/// A checkpoint that does not fit: the old one stays, whole.
/// @pre runs in a process of its own
void full_disk(const Setup& setup) {
  const auto file =
      std::filesystem::temp_directory_path() / fmt::format("weft_full_disk_{}.weft", ::getpid());
  Simulation simulation = start(small_scene(setup), setup);
  watch(simulation, 5);
  simulation.save(file);
  const std::uint64_t saved = simulation.state_hash();
  watch(simulation, 5);
  limit_files(1000);
  std::string refusal;
  try {
    simulation.save(file);
  } catch (const SceneError& error) {
    refusal = error.what();
  } catch (const std::filesystem::filesystem_error& error) {
    refusal = error.what();
  }
  Simulation other = start(small_scene(setup), setup);
  other.resume(file);
  const bool as_before = other.state_hash() == saved;
  std::filesystem::remove(file);
  if (refusal.empty()) throw Wrong("a checkpoint that did not fit was not refused");
  if (!as_before) throw Wrong("the old checkpoint is not as it was");
  watch(simulation, 5);  // goes on all the same
  // Without the name of the file, which is another one each time.
  const auto colon = refusal.find(": ");
  throw SceneError("checkpoint" + (colon == std::string::npos ? "" : refusal.substr(colon)));
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
