#include "weft/devices.hpp"

#include <algorithm>
#include <charconv>
#include <thread>

#include "host/exec/host_device.hpp"
#include "weft/error.hpp"

namespace weft {
namespace {

constexpr int max_host_ranks = 64;

[[noreturn]] void refuse(std::string_view text) {
  throw SceneError("", "device", "\"" + std::string(text) + "\"",
                   "auto, cpu, cpu:N (1 <= N <= 64), cuda, cuda:0,1");
}

int parse_number(std::string_view digits, std::string_view text) {
  int value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc() || end != digits.data() + digits.size() || value < 0) refuse(text);
  return value;
}

}  // namespace

DeviceSet host_devices(int n, const HostDeviceOptions& options) {
  if (n < 1 || n > max_host_ranks)
    throw DeviceError("cannot make " + std::to_string(n) + " host devices; allowed: 1 to 64");
  std::vector<std::unique_ptr<Device>> devices;
  for (int rank = 0; rank < n; ++rank)
    devices.push_back(std::make_unique<HostDevice>(rank, options));
  return DeviceSet(std::move(devices));
}

#if !defined(WEFT_CUDA)
DeviceSet cuda_devices(const std::vector<int>&) {
  throw DeviceError("this build of weft has no CUDA; use --device cpu, or build with WEFT_CUDA=ON");
}
#endif

DeviceSet parse_devices(std::string_view text) {
  const int cores =
      std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, max_host_ranks);
  if (text == "auto" || text == "cpu") return host_devices(cores);
  if (text == "cuda") return cuda_devices({0});
  if (text.starts_with("cpu:")) {
    const int n = parse_number(text.substr(4), text);
    if (n < 1 || n > max_host_ranks) refuse(text);
    return host_devices(n);
  }
  if (text.starts_with("cuda:")) {
    std::vector<int> cards;
    std::string_view rest = text.substr(5);
    while (true) {
      const std::size_t comma = rest.find(',');
      cards.push_back(parse_number(rest.substr(0, comma), text));
      if (comma == std::string_view::npos) break;
      rest = rest.substr(comma + 1);
    }
    return cuda_devices(cards);
  }
  refuse(text);
}

}  // namespace weft
