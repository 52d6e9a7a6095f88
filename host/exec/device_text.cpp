#include "host/exec/device_text.hpp"

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <numeric>
#include <thread>

#include "weft/error.hpp"

namespace weft {
namespace {

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

std::string DeviceText::text() const {
  if (automatic) return "auto";
  if (backend == Backend::host)
    return "cpu:" + std::to_string(host_ranks > 0 ? host_ranks : usual_host_ranks());
  std::string list;
  for (const int card : cards) list += (list.empty() ? "" : ",") + std::to_string(card);
  return "cuda:" + list;
}

DeviceText read_device_text(std::string_view text) {
  DeviceText asked;
  if (text == "auto" || text == "cpu") {
    asked.automatic = text == "auto";
    return asked;
  }
  if (text.starts_with("cpu:")) {
    asked.host_ranks = parse_number(text.substr(4), text);
    if (asked.host_ranks < 1 || asked.host_ranks > max_host_ranks) refuse(text);
    return asked;
  }
  asked.backend = Backend::cuda;
  if (text == "cuda") {
    asked.cards = {0};
    return asked;
  }
  if (!text.starts_with("cuda:")) refuse(text);
  std::string_view rest = text.substr(5);
  while (true) {
    const std::size_t comma = rest.find(',');
    asked.cards.push_back(parse_number(rest.substr(0, comma), text));
    if (comma == std::string_view::npos) return asked;
    rest = rest.substr(comma + 1);
  }
}

int usual_host_ranks() {
  return std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, max_host_ranks);
}

std::string first_cards_text(int count) {
  DeviceText first;
  first.backend = Backend::cuda;
  first.cards.resize(static_cast<std::size_t>(count));
  std::iota(first.cards.begin(), first.cards.end(), 0);
  return first.text();
}

}  // namespace weft
