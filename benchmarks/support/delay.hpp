#pragma once

#include "weft/exec/device.hpp"

namespace weft::bench {

/// Keeps a GPU busy for about this long, so that what is submitted meanwhile runs without gaps. Of
/// builds with CUDA.
/// @param queue        a CUDA queue
/// @param microseconds at most 1,000
/// @throws DeviceError if the GPU does not take the launch
void delay(Queue& queue, int microseconds);

}  // namespace weft::bench
