#pragma once

#include <cstdint>

#include "weft/devices.hpp"

namespace weft {

/// How host devices behave under test. Results never depend on it.
struct HostDeviceOptions {
  bool poison = false;           ///< fill new memory with NaN bytes, to expose a missing copy
  std::uint64_t delay_seed = 0;  ///< not 0: delay each piece of work by a pseudo-random time
  Executor executor{};           ///< empty: ranks bring their threads
};

/// As host_devices(n), but a single rank has threads if delay_seed is set.
DeviceSet host_devices(int n, const HostDeviceOptions& options);

}  // namespace weft
