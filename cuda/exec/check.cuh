#pragma once

#include <cuda_runtime.h>

#include <source_location>
#include <string>
#include <string_view>

#include "weft/error.hpp"

namespace weft::cuda {

/// Stands for "no rank in particular" in messages.
inline constexpr int no_rank = -1;

/// Where a call stands, from the tree's root: "cuda/exec/cuda_device.cu:40".
inline std::string place(const std::source_location& where) {
  std::string_view file = where.file_name();
  if (const std::size_t root = file.rfind("/cuda/"); root != std::string_view::npos)
    file.remove_prefix(root + 1);
  return std::string(file) + ":" + std::to_string(where.line());
}

/// Throws unless a call of the CUDA runtime succeeded, and clears the error that it left behind, so
/// that the next check does not see it again.
/// @param error what the call returned
/// @param api   name of the function that was called
/// @param rank  rank that called it, or no_rank
/// @throws DeviceError with rank, function, file and line, and CUDA's own words
inline void check(cudaError_t error, const char* api, int rank,
                  const std::source_location& where = std::source_location::current()) {
  if (error == cudaSuccess) return;
  cudaGetLastError();
  const std::string who = rank == no_rank ? "" : "rank " + std::to_string(rank) + ": ";
  throw DeviceError(who + api + " failed at " + place(where) + ": " + cudaGetErrorString(error) +
                    " (" + cudaGetErrorName(error) + ")");
}

}  // namespace weft::cuda
