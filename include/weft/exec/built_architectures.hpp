#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>

namespace weft {

/// One word of CMAKE_CUDA_ARCHITECTURES: "90" is machine code and PTX, "90-real" machine code
/// alone, "90-virtual" PTX alone; a letter behind the number ("90a") is for that GPU alone.
struct BuiltArchitecture {
  int major = 0;
  int minor = 0;
  bool code = false;
  bool ptx = false;
  bool exact = false;

  /// Machine code runs on GPUs of its major number from its minor number on; PTX is compiled by the
  /// driver for any GPU from its number on.
  bool runs_on(int gpu_major, int gpu_minor) const {
    if (exact) return major == gpu_major && minor == gpu_minor;
    if (code && major == gpu_major && minor <= gpu_minor) return true;
    return ptx && (major < gpu_major || (major == gpu_major && minor <= gpu_minor));
  }
};

/// @return without numbers for a word that names none, such as "all" or "native"
inline BuiltArchitecture read_architecture(std::string_view word) {
  BuiltArchitecture result;
  int number = 0;
  std::size_t k = 0;
  for (; k < word.size() && word[k] >= '0' && word[k] <= '9'; ++k)
    number = 10 * number + (word[k] - '0');
  const std::string_view rest = word.substr(k);
  result.major = number / 10;
  result.minor = number % 10;
  result.exact = !rest.empty() && rest.front() >= 'a' && rest.front() <= 'z';
  result.code = !rest.ends_with("-virtual");
  result.ptx = !rest.ends_with("-real");
  return result;
}

/// Why the kernels of this build cannot run on a GPU.
/// @param built what they were compiled for, with commas: "80-real,90"
/// @param gpu   name of the GPU for the message, such as "cuda:0, NVIDIA T4"
/// @return empty if they can, or if `built` does not say
inline std::string missing_architecture(std::string_view built, const std::string& gpu, int major,
                                        int minor) {
  std::string known;
  while (!built.empty()) {
    const std::size_t end = std::min(built.find(','), built.size());
    const BuiltArchitecture one = read_architecture(built.substr(0, end));
    built.remove_prefix(std::min(end + 1, built.size()));
    if (one.major == 0 || one.runs_on(major, minor)) return {};
    known +=
        (known.empty() ? "" : ", ") + std::to_string(one.major) + "." + std::to_string(one.minor);
  }
  if (known.empty()) return {};
  const std::string number = std::to_string(major) + std::to_string(minor);
  return gpu + " has compute capability " + std::to_string(major) + "." + std::to_string(minor) +
         ", for which this build of weft has no code; it has " + known +
         "; build with CUDAARCHS=" + number + ", or use --device cpu";
}

}  // namespace weft
