#pragma once

#include <string>
#include <vector>

namespace weft {

/// One line a card, for people: name, memory, compute capability, measured copy bandwidth and the
/// cards whose memory it reaches directly. One line that says so where there is no driver or no
/// card. Takes some 512 MiB of each card for a moment. Only in builds with CUDA.
std::vector<std::string> describe_cuda_devices();

}  // namespace weft
