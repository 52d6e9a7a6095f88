#pragma once

#include <memory>
#include <string>

namespace weft {

/// What it takes to get data from one GPU's memory to another's.
struct LinkFigures {
  bool peer = false;          ///< kernels of one reach the memory of the other
  double load_latency = 0;    ///< [s] a load by a kernel that waits for the one before; peers alone
  double load_bandwidth = 0;  ///< [B/s] loads by a kernel; peers alone
  double copy_latency = 0;    ///< [s] a copy of next to nothing that the host issues
  double copy_bandwidth = 0;  ///< [B/s] of a large one
};

/// Measures the GPUs of a machine, each figure when it is asked for. A figure takes a few
/// milliseconds, and what a GPU takes to wake up.
class MachineProbe {
 public:
  virtual ~MachineProbe() = default;
  /// GPUs, 0 to count - 1. 0 where there is no driver or no GPU; why_none() says so.
  /// @throws DeviceError if there are GPUs, but none can be asked
  virtual int gpu_count() = 0;
  /// One line; empty where there are GPUs.
  virtual std::string why_none() = 0;
  /// @throws DeviceError with the GPU
  virtual std::string name(int gpu) = 0;
  /// Bytes read and written a second by a copy within the GPU's memory. [B/s]
  /// @throws DeviceError with the GPU
  virtual double bandwidth(int gpu) = 0;
  /// Receiving on GPU `to` what GPU `from` has.
  /// @throws DeviceError with the GPUs
  virtual LinkFigures link(int from, int to) = 0;
};

/// Measures this machine's GPUs. Only in builds with CUDA.
std::unique_ptr<MachineProbe> cuda_machine_probe();

}  // namespace weft
