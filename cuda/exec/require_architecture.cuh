#pragma once

#include <cuda_runtime.h>

#include <string>

#include "cuda/exec/check.cuh"
#include "weft/error.hpp"
#include "weft/exec/built_architectures.hpp"

namespace weft::cuda {

/// Refuses a GPU that none of this build's kernels can run on, before one fails there.
/// @param rank that is to use it, or no_rank
/// @throws DeviceError that names the GPU, and what this build was compiled for
inline void require_architecture(int gpu, int rank) {
  cudaDeviceProp properties;
  check(cudaGetDeviceProperties(&properties, gpu), "cudaGetDeviceProperties", rank);
  const std::string missing = missing_architecture(
      WEFT_CUDA_ARCHITECTURES, "cuda:" + std::to_string(gpu) + ", " + properties.name,
      properties.major, properties.minor);
  if (!missing.empty()) throw DeviceError(missing);
}

}  // namespace weft::cuda
