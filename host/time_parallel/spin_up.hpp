#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "host/time_parallel/coarse_scene.hpp"
#include "weft/scene.hpp"

// A way to the start of a slice that does not begin at its own step: from an earlier state of the
// coarse run, which nothing intersects in, and on with the method of the slices.

namespace weft {

/// First steps of the states that the start of a slice may be made from, in the order in which they
/// are tried: its own; that of the coarse step before; ever earlier ones, twice as far back each
/// time; in the end 0, the start of the run.
/// @param step            of the slice, >= 1
/// @param steps_a_coarse  fine steps that a coarse one is as long as, >= 1
std::vector<std::int64_t> spin_up_starts(std::int64_t step, double steps_a_coarse);

/// Takes steps of a slice's method until the one that the slice begins with.
/// @param fine   with the method of the slices
/// @param from   checkpoint to begin from; empty: the start of the scene
/// @param step   of the slice
/// @param states directory of the coarse run
/// @param file   checkpoint to write
/// @param took   told the counted work of a step, before the first one 0; false: end at once,
///               nothing is written
/// @return whether it is written
/// @throws SimulationError if a step fails
bool spin_up(const Scene& fine, const CoarseScene& level, const std::filesystem::path& from,
             std::int64_t step, const std::filesystem::path& states,
             const std::filesystem::path& file, const std::function<bool(double work)>& took);

}  // namespace weft
