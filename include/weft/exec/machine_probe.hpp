#pragma once

#include <memory>
#include <string>

namespace weft {

/// What it takes to get data from one card's memory to another's.
struct LinkFigures {
  bool peer = false;          ///< kernels of one reach the memory of the other
  double load_latency = 0;    ///< [s] a load by a kernel that waits for the one before; peers alone
  double load_bandwidth = 0;  ///< [B/s] loads by a kernel; peers alone
  double copy_latency = 0;    ///< [s] a copy of next to nothing that the host issues
  double copy_bandwidth = 0;  ///< [B/s] of a large one
};

/// Measures the cards of a machine, each figure when it is asked for. A figure takes a few
/// milliseconds, and what a card takes to wake up.
class MachineProbe {
 public:
  virtual ~MachineProbe() = default;
  /// Cards, 0 to count - 1. 0 where there is no driver or no card; why_none() says so.
  /// @throws DeviceError if there are cards, but none can be asked
  virtual int card_count() = 0;
  /// One line; empty where there are cards.
  virtual std::string why_none() = 0;
  /// @throws DeviceError with the card
  virtual std::string name(int card) = 0;
  /// Bytes read and written a second by a copy within the card's memory. [B/s]
  /// @throws DeviceError with the card
  virtual double bandwidth(int card) = 0;
  /// Receiving on card `to` what card `from` has.
  /// @throws DeviceError with the cards
  virtual LinkFigures link(int from, int to) = 0;
};

/// Measures this machine's cards. Only in builds with CUDA.
std::unique_ptr<MachineProbe> cuda_machine_probe();

}  // namespace weft
