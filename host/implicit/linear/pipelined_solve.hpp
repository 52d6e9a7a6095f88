#pragma once

#include <vector>

#include "host/implicit/parallel/exchange.hpp"
#include "host/implicit/parallel/work_queues.hpp"
#include "weft/exec/buffer.hpp"
#include "weft/kernels/solve/pipelined.hpp"
#include "weft/scene.hpp"

namespace weft {

/// The transport of linear solves on these devices: that of the settings. `automatic` means
/// pipelined only if devices cannot access each other's memory.
/// @return peer or pipelined
Transport choose_transport(const SolverSettings& settings, const DeviceSet& devices);

/// Conjugate gradients over ranks that exchange data only by copies issued by the host: the
/// transport `pipelined` (P-Cloth section 3.1). An iteration updates own rows, then goes through
/// the stages of the work queues: transfer queues copy whole sub-vectors of u while compute queues
/// multiply the rows that have become complete. The ranks then exchange partial sums, and
/// every rank computes the scalars from them. Same bits as SolvePcg.
template <class T>
class PipelinedSolve {
 public:
  /// @param row_begin    [ranks + 1], see SolvePcg
  /// @param partial_rows the same as in the solves
  /// @throws DeviceError if there is not enough memory
  PipelinedSolve(DeviceSet& devices, const std::vector<Index>& row_begin, Index partial_rows);

  /// Whether products wait for all sub-vectors instead of overlapping with their transfer. This is
  /// P-Cloth's baseline (Fig. 3(a), eq. (6), after Cevahir et al. 2009). Changes no bits.
  /// @pre no solve is running
  void gather_before_products(bool gather);

  /// Solves, and waits for it. x and status of all parts are as after SolvePcg.
  /// @param solves [ranks] `parts` and `epoch` are not used
  /// @param parts  [ranks]
  void solve(const std::vector<SolvePcg<T>>& solves, const std::vector<SolvePcgPart<T>>& parts);

 private:
  struct Rank {
    std::vector<Transfer> queue;
    Buffer<unsigned char> arrival;
    Buffer<unsigned char> group_stage;
    Buffer<PipelinedState<T>> state;
    SolvePipelined<T> args;  ///< of the solve under way
  };

  int ranks() const { return devices_->size(); }
  Rank& rank(int r) { return ranks_[static_cast<std::size_t>(r)]; }
  void launch_one(int r, PipelinedWork work, int stage = 0);
  void launch_all(PipelinedWork work);
  void copy_vector(Span<Vec3<T>> SolvePcgPart<T>::*vector, int r, const Transfer& transfer);
  void multiply(Span<Vec3<T>> SolvePcgPart<T>::*vector, PipelinedWork work);
  void join_transfers(const std::vector<Event>& copied);
  void reduce(PipelinedWork sums, PipelinedWork taken);
  void begin_recurrence(bool with_magnitude);
  void iterate();
  PipelinedState<T> state();

  DeviceSet* devices_;
  std::vector<Index> row_begin_;
  std::vector<GatherPiece> partials_;  ///< of the ranks
  std::vector<Rank> ranks_;
  bool only_if_running_ = false;  ///< later launches do nothing once the solve has ended
  bool gather_ = false;
};

}  // namespace weft
