#include "weft/exec/describe.hpp"

#include <fstream>
#include <thread>

#include "weft/devices.hpp"

namespace weft {
namespace {

/// The processor's name as Linux gives it, or "unknown processor".
std::string processor_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with("model name")) continue;
    const std::size_t colon = line.find(':');
    const std::size_t first =
        colon == std::string::npos ? colon : line.find_first_not_of(" \t", colon + 1);
    if (first != std::string::npos) return line.substr(first);
  }
  return "unknown processor";
}

}  // namespace

std::vector<std::string> describe_devices() {
  const unsigned threads = std::thread::hardware_concurrency();
  std::vector<std::string> lines = {"cpu: " + processor_name() + ", " +
                                    (threads == 0 ? "?" : std::to_string(threads)) + " threads"};
#if defined(WEFT_CUDA)
  for (std::string& line : describe_cuda_devices()) lines.push_back(std::move(line));
#else
  lines.push_back("cuda: not in this build");
#endif
  return lines;
}

}  // namespace weft
