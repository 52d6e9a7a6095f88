#pragma once

#include <filesystem>
#include <functional>

#include "weft/frame.hpp"
#include "weft/scene.hpp"
#include "weft/simulation.hpp"

namespace weft {

/// The states on both sides of a seam, on the meshes that the slice after it starts with.
struct BoundarySides {
  const Scene& scene;  ///< has these meshes
  Frame before;        ///< end of the slice before
  Frame after;         ///< start
};

/// Reads states at the seams of a run, for one thread at a time.
class BoundaryStates {
 public:
  /// @param fine with the method of the slices
  /// @param run  directory of the whole run, whose slices are done
  BoundaryStates(const Scene& fine, std::filesystem::path run);

  /// What is at a seam. Where slices remesh, the end of the slice before is interpolated in
  /// material space.
  /// @param slice after it, >= 1
  /// @return      its scene until the next call
  /// @throws SceneError if a file is missing or damaged
  BoundarySides at(int slice);

  /// Whether the end of the slice before it could be the start of a scene, as it is.
  bool free_before(int slice);

 private:
  std::filesystem::path run_;
  Simulation simulation_;
};

/// Looks at every seam of a run, on several threads.
/// @param look called once with the number of the slice after each seam, for BoundaryStates::at()
/// @throws what the first thread that fails has thrown
void for_each_seam(const Scene& fine, const std::filesystem::path& run, int slices, int threads,
                   const std::function<void(int slice, BoundaryStates& states)>& look);

}  // namespace weft
