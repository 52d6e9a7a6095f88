#include "host/exec/device_text.hpp"

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <numeric>
#include <optional>
#include <thread>

#include "weft/error.hpp"

namespace weft {
namespace {

/// All of the digits, as a number; -1: they are none.
int number_of(std::string_view digits) {
  int value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  return error != std::errc() || end != digits.data() + digits.size() ? -1 : value;
}

std::optional<DeviceText> parse(std::string_view text) {
  DeviceText asked;
  if (text == "auto" || text == "cpu") {
    asked.automatic = text == "auto";
    return asked;
  }
  if (text.starts_with("cpu:")) {
    asked.host_ranks = number_of(text.substr(4));
    if (asked.host_ranks < 1 || asked.host_ranks > max_host_ranks) return {};
    return asked;
  }
  asked.backend = Backend::cuda;
  if (text == "cuda") {
    asked.gpus = {0};
    return asked;
  }
  if (!text.starts_with("cuda:")) return {};
  std::string_view rest = text.substr(5);
  while (true) {
    const std::size_t comma = rest.find(',');
    asked.gpus.push_back(number_of(rest.substr(0, comma)));
    if (asked.gpus.back() < 0) return {};
    if (comma == std::string_view::npos) return asked;
    rest = rest.substr(comma + 1);
  }
}

}  // namespace

std::string DeviceText::text() const {
  if (automatic) return "auto";
  if (backend == Backend::host)
    return "cpu:" + std::to_string(host_ranks > 0 ? host_ranks : usual_host_ranks());
  std::string list;
  for (const int gpu : gpus) list += (list.empty() ? "" : ",") + std::to_string(gpu);
  return "cuda:" + list;
}

bool is_device_text(std::string_view text) {
  return parse(text).has_value();
}

DeviceText read_device_text(std::string_view text) {
  const std::optional<DeviceText> asked = parse(text);
  if (!asked) throw SceneError("", "device", "\"" + std::string(text) + "\"", device_texts);
  return *asked;
}

int usual_host_ranks() {
  return std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, max_host_ranks);
}

std::string first_gpus_text(int count) {
  DeviceText first;
  first.backend = Backend::cuda;
  first.gpus.resize(static_cast<std::size_t>(count));
  std::iota(first.gpus.begin(), first.gpus.end(), 0);
  return first.text();
}

}  // namespace weft
