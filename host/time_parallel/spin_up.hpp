#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "host/time_parallel/coarse_scene.hpp"
#include "weft/scene.hpp"

// Spin-up: the start of a slice from an earlier state of the coarse run without intersections. The
// method of the slices simulates the steps between the two.

namespace weft {

/// Steps of the states from which the start of a slice may be made, in the order of trial: the
/// first step of the slice itself; that of the previous coarse step; earlier ones, twice as far
/// back each time; finally 0, the start of the run.
/// @param step            first step of the slice, >= 1
/// @param steps_a_coarse  fine steps per coarse step, >= 1
std::vector<std::int64_t> spin_up_starts(std::int64_t step, double steps_a_coarse);

/// Simulates up to the first step of a slice, with the method of the slices.
/// @param fine   scene with the method of the slices
/// @param from   checkpoint to begin from; empty: the start of the scene
/// @param step   first step of the slice
/// @param file   checkpoint to write
/// @param took   called with the counted work of each step, and with 0 before the first; false: end
///               at once and write nothing
/// @return whether the checkpoint was written
/// @throws SimulationError if a step fails
bool spin_up(const Scene& fine, const std::filesystem::path& from, std::int64_t step,
             const std::filesystem::path& file, const std::function<bool(double work)>& took);

}  // namespace weft
