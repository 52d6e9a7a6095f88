#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "weft/exec/device.hpp"

namespace weft {

struct Scene;

/// How host devices behave under test. Results never depend on it.
struct HostDeviceOptions {
  bool poison = false;           ///< fill fresh memory with NaN bytes, so that a missed copy shows
  std::uint64_t delay_seed = 0;  ///< not 0: delay each piece of work by a pseudo-random time
};

/// n ranks on this machine's processor, each with its own memory and its own threads; a single one
/// works on the thread that calls, unless its work is delayed.
/// @throws DeviceError unless 1 <= n <= 64
DeviceSet host_devices(int n, const HostDeviceOptions& options = {});

/// One rank per entry, on the GPU of that number. A GPU that is listed twice carries two ranks.
/// @throws DeviceError if this build has no CUDA, or a GPU is missing
DeviceSet cuda_devices(const std::vector<int>& gpus);

/// Reads "auto", "cpu", "cpu:N", "cuda" or "cuda:0,1".
/// "cpu" takes a rank a processor core; "cuda" takes GPU 0. "auto" is as "cpu" here, where no
/// scene is known; see choose_devices().
/// @throws SceneError if the text is none of these
/// @throws DeviceError naming rank and GPU if a GPU is missing or cannot be used
DeviceSet parse_devices(std::string_view text);

/// Time of one iteration of the linear solve on so many GPUs, by P-Cloth's model of overheads
/// (section 3.1.1) and the machine's own figures.
struct DeviceEstimate {
  int gpus = 1;
  std::string transport;  ///< "peer" or "pipelined"; empty: one GPU
  double seconds = 0;     ///< [s]
};

/// What "auto" stands for on this machine.
struct DeviceChoice {
  std::string device;  ///< for parse_devices(): "cpu:8" or "cuda:0,1"; see look_for_devices()
  std::string reason;  ///< why no other; one line
  std::vector<DeviceEstimate> estimates;  ///< by number of GPUs; empty on the CPU
  std::vector<std::string> figures;       ///< what was measured, a line a GPU and a link
};

/// Doubles the number of GPUs as long as that saves enough time; chooses the CPU if there is no
/// GPU, or if the scene's method runs best there. Measures GPUs and links for some milliseconds
/// each. The number of GPUs changes no result, but GPUs and CPU give different bits: record the
/// choice to repeat a run.
/// @param scene valid
/// @throws DeviceError if a GPU cannot be measured
DeviceChoice choose_devices(const Scene& scene);

/// As choose_devices(), but a GPU that cannot be measured is no error: the choice then names no
/// device, and its reason is what failed. For looking at a machine, not for running on it.
/// @param scene valid
DeviceChoice look_for_devices(const Scene& scene);

/// One line about each device that this build can use, for people.
std::vector<std::string> describe_devices();

/// One line about each link between two GPUs, measured; none where there are fewer.
/// @throws DeviceError if a GPU cannot be measured
std::vector<std::string> describe_links();

}  // namespace weft
