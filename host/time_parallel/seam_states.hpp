#pragma once

#include <array>
#include <filesystem>
#include <functional>

#include "weft/frame.hpp"
#include "weft/scene.hpp"
#include "weft/simulation.hpp"

namespace weft {

/// Reads states at the seams of a run, for one thread at a time.
class SeamStates {
 public:
  /// @param fine with the method of the slices
  /// @param run  directory of the whole run, whose slices are done
  SeamStates(const Scene& fine, std::filesystem::path run);

  /// The states on both sides of a seam: the end of the slice before, and the start.
  /// @param slice after it, >= 1
  /// @throws SceneError if a file is missing or damaged
  std::array<Frame, 2> at(int slice);

 private:
  std::filesystem::path run_;
  Simulation simulation_;
};

/// Looks at every seam of a run, on several threads.
/// @param look called once with the number of the slice after each seam
/// @throws what the first thread that fails has thrown
void for_each_seam(const Scene& fine, const std::filesystem::path& run, int slices, int threads,
                   const std::function<void(int slice, const std::array<Frame, 2>& states)>& look);

}  // namespace weft
