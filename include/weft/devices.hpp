#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "weft/exec/device.hpp"

namespace weft {

struct Scene;

/// n ranks on this machine's processor, each with its own memory. The first one works on the
/// calling thread, while that waits for any of them; each of the others has a thread.
/// @throws DeviceError unless 1 <= n <= 64
DeviceSet host_devices(int n);

/// Calls `work` once, soon, on a thread other than the caller's. It must not throw.
using Executor = std::function<void(std::function<void()> work)>;

/// n ranks on threads of the program's, such as those of a job system. Ranks wait for each other:
/// if the executor has been given up to 2 n pieces of work that have not returned, all of them must
/// run at once. A piece returns as soon as its rank has nothing to do. Results are those of
/// host_devices(n). A single rank makes no use of the executor.
/// @throws DeviceError unless 1 <= n <= 64
/// @throws std::bad_function_call if the executor is empty
DeviceSet host_devices(int n, Executor executor);

/// One rank per entry, on the GPU of that number. A GPU that is listed twice carries two ranks.
/// @throws DeviceError if this build has no CUDA, or a GPU is missing
DeviceSet cuda_devices(const std::vector<int>& gpus);

/// Reads "auto", "cpu", "cpu:N", "cuda" or "cuda:0,1".
/// "cpu" takes one rank per processor core; "cuda" takes GPU 0. "auto" means "cpu" here, because
/// no scene is known; see choose_devices().
/// @throws SceneError if the text is none of these
/// @throws DeviceError naming rank and GPU if a GPU is missing or cannot be used
DeviceSet parse_devices(std::string_view text);

/// Leaves the choice to the simulation, which asks choose_devices().
struct AutoDevice {};
inline AutoDevice auto_device() {
  return {};
}

/// Predicted time of a step of a typical scene on `gpus` GPUs, from P-Cloth's model of overheads
/// (section 3.1.1) with bandwidths and latencies that are measured on this machine.
struct DeviceEstimate {
  int gpus = 1;
  std::string transport;  ///< "peer" or "pipelined"; empty for one GPU
  double seconds = 0;     ///< [s]
};

/// What "auto" stands for on this machine.
struct DeviceChoice {
  std::string device;  ///< for parse_devices(); may be empty, see look_for_devices()
  std::string reason;  ///< why this device; one line
  std::vector<DeviceEstimate> estimates;  ///< by number of GPUs; empty on the CPU
  std::vector<std::string> figures;       ///< measurements, one line per GPU and per link
};

/// Doubles the number of GPUs as long as that saves enough time; chooses the CPU if there is no
/// GPU, or if the scene's method runs best there. Measures GPUs and links for some milliseconds
/// each. Results do not depend on the number of GPUs, but GPUs and CPU give different bits.
/// To repeat a run exactly, record the choice.
/// @param scene valid
/// @throws DeviceError if a GPU cannot be measured
DeviceChoice choose_devices(const Scene& scene);

/// As choose_devices(), but a GPU that cannot be measured is not an error: `device` is then empty
/// and `reason` says what failed. Use it to describe a machine, not to run on it.
/// @param scene valid
DeviceChoice look_for_devices(const Scene& scene);

/// One human-readable line for each device that this build can use.
std::vector<std::string> describe_devices();

/// One line with measurements for each link between two GPUs; empty with fewer than two GPUs.
/// @throws DeviceError if a GPU cannot be measured
std::vector<std::string> describe_links();

}  // namespace weft
