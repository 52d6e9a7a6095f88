#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "host/app/time_parallel/slice_protocol.hpp"

namespace weft::app {

/// How many processes an MPI launcher has started beside this one, and this one; 1: none has.
/// @throws SceneError if one has, and this program was built without WEFT_MPI
int mpi_rank_count();

/// @throws SceneError in any but the first process of a launcher that does not tell how many there
///         are: each would take the run of slices for its own
void refuse_uncounted_ranks();

/// The processes that `mpirun -n P weft run` has started. The first one decides and writes the
/// run's directory, which all of them see; the others simulate slices for it. MPI carries the lines
/// of slice_talk.hpp; states go by files.
class SliceRanks {
 public:
  /// @throws DeviceError if MPI serves no several threads
  SliceRanks();
  SliceRanks(const SliceRanks&) = delete;
  SliceRanks& operator=(const SliceRanks&) = delete;
  /// Of the first rank: lets the others go.
  ~SliceRanks();

  bool first() const;  ///< whether this is the rank that decides

  /// What the other ranks do: simulate slices until they are let go.
  /// @param folders of the files that the scene names
  void serve(const std::vector<std::string>& folders);

  /// Has a rank simulate a slice that has none yet. Called by several threads of the first rank.
  /// @param device for parse_devices()
  /// @param frame  called after frames were kept
  /// @return       false if none is free: nothing was done
  /// @throws SceneError, DeviceError, SimulationError that ended the slice
  bool run(const std::filesystem::path& scene, const std::string& device, const SliceTask& task,
           SliceGate& gate, const std::function<void()>& frame, SliceOutcome& outcome);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace weft::app
