#pragma once

#include <string>
#include <vector>

namespace weft {

/// One line a GPU, for people: name, memory, compute capability, measured copy bandwidth and the
/// GPUs whose memory it reaches directly. One line that says so where there is no driver or no
/// GPU. Takes some 512 MiB of each GPU for a moment. Only in builds with CUDA.
std::vector<std::string> describe_cuda_devices();

/// Bytes read and written a second by a copy within the GPU's memory, best of a few [B/s]. Only in
/// builds with CUDA.
/// @throws DeviceError if there is not enough memory
double cuda_copy_bandwidth(int gpu);

}  // namespace weft
