#include <utility>

#include "host/exec/device_text.hpp"
#include "host/exec/host_device.hpp"
#include "weft/error.hpp"

namespace weft {

DeviceSet host_devices(int n) {
  return host_devices(n, HostDeviceOptions{});
}

DeviceSet host_devices(int n, Executor executor) {
  if (!executor) throw std::bad_function_call();
  return host_devices(n, HostDeviceOptions{.executor = std::move(executor)});
}

DeviceSet host_devices(int n, const HostDeviceOptions& options) {
  if (n < 1 || n > max_host_ranks)
    throw DeviceError("cannot make " + std::to_string(n) + " host devices; allowed: 1 to 64");
  std::vector<std::unique_ptr<Device>> devices;
  const HostDevice* first = nullptr;
  for (int rank = 0; rank < n; ++rank) {
    auto device = std::make_unique<HostDevice>(rank, n == 1, options, first);
    if (rank == 0) first = device.get();
    devices.push_back(std::move(device));
  }
  return DeviceSet(std::move(devices));
}

#if !defined(WEFT_CUDA)
DeviceSet cuda_devices(const std::vector<int>&) {
  throw DeviceError("this build of weft has no CUDA; use --device cpu, or build with WEFT_CUDA=ON");
}
#endif

DeviceSet parse_devices(std::string_view text) {
  const DeviceText asked = read_device_text(text);
  if (asked.backend == Backend::cuda) return cuda_devices(asked.gpus);
  return host_devices(asked.host_ranks > 0 ? asked.host_ranks : usual_host_ranks());
}

}  // namespace weft
