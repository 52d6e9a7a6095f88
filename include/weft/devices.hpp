#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "weft/exec/device.hpp"

namespace weft {

/// How host devices behave under test. Results never depend on it.
struct HostDeviceOptions {
  bool poison = false;           ///< fill fresh memory with NaN bytes, so that a missed copy shows
  std::uint64_t delay_seed = 0;  ///< not 0: delay each piece of work by a pseudo-random time
};

/// n ranks on this machine's processor, each with its own threads and its own memory.
/// @throws DeviceError unless 1 <= n <= 64
DeviceSet host_devices(int n, const HostDeviceOptions& options = {});

/// One rank a number, on the card of that number; a card named twice carries two ranks.
/// @throws DeviceError if this build has no CUDA, or a card is missing
DeviceSet cuda_devices(const std::vector<int>& cards);

/// Reads "auto", "cpu", "cpu:N", "cuda" or "cuda:0,1".
/// "auto" and "cpu" take a rank a processor core; "cuda" takes card 0.
/// @throws SceneError if the text is none of these
DeviceSet parse_devices(std::string_view text);

/// One line about each device that this build can use, for people.
std::vector<std::string> describe_devices();

}  // namespace weft
