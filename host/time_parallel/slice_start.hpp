#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "host/time_parallel/coarse_scene.hpp"
#include "weft/report.hpp"
#include "weft/scene.hpp"

namespace weft {

/// Work that a step took by what was counted, in products of one row: for time that does not
/// depend on the machine, or on what else it does. Pairs are not in it: how many are listed depends
/// on how long ago they were searched, which a resumed run does not know. A remesh after the step
/// is.
/// @param rows cloth vertices in the step: before that
double counted_work(const StepReport& report, std::int64_t rows);

/// What a remesh comes to in that.
/// @param rows cloth vertices after it
double remesh_work(std::int64_t rows);

/// Cloth vertices of the meshes as they are now.
std::int64_t cloth_rows(const Scene& scene);

/// What counted_work() is above for any step.
double least_work(std::int64_t rows);

/// Steps of detail recovery by Liang & Lin 2018, section 5.3: c0 sqrt(m / xi) / step, with m the
/// mass per area and xi the Frobenius norm of the stiffness matrices of stretching and bending, of
/// the cloth where that is most; or as many as the scene says.
/// @param step [s]
int recovery_iterations(const Scene& scene, double step);

/// Largest side of the box around the cloths as they start. [m]
double cloth_size(const Scene& scene);

/// How the start of a slice was made.
struct SliceStart {
  int iterations_max = 0;  ///< by the formula
  int iterations = 0;      ///< of recovery that were done
  double change = 0;       ///< see TimeParallelSettings::recovery_tolerance; of the last iteration
  double tracking_error = 0;  ///< [m] see StepReport; after the last iteration
  double untangled = 0;       ///< [m] farthest that a vertex was moved to part what intersected
  double work = 0;            ///< counted_work() of recoveries and run-ins, refused ones too
  std::string note;           ///< why recovery ended early; empty: it did not
  std::int64_t spin_up = 0;   ///< steps from an earlier state to this one
  std::string refused;        ///< why none was made of the state at its own step; empty: one was
};

/// Makes the state in which a slice starts, and writes it as a checkpoint (Liang & Lin 2018,
/// Algorithm 2). The coarse state is upsampled, and what then intersects is parted, as at the start
/// of a scene. Then, again and again: one step back, by the change of the coarse run over one fine
/// step, and one step forward by the implicit method, in which averages stay those of the coarse
/// run. Either motion is certified to be free of intersections; where one is not to be had,
/// recovery ends with what it has. Velocities are in the end those of the coarse run, upsampled.
/// What intersects, in the precision of the run, before recovery or after it, begins no slice: the
/// start is then made from an earlier state, and steps of the slices' method lead to it, see
/// spin_up_starts(). The last one is the start of the run.
/// @param fine      with the method of the slices
/// @param step      first step of the slice, >= 1
/// @param states    directory of the coarse run, which has got beyond that step
/// @param file      checkpoint to write
/// @param go_on     asked before each iteration, with the work so far; false: end at once, nothing
/// is written
/// @throws SimulationError if a step fails on the way from the start of the run, which is tried
/// last
/// @throws SceneError if a file cannot be read or written
SliceStart write_slice_start(const Scene& fine, const CoarseScene& level, std::int64_t step,
                             const std::filesystem::path& states, const std::filesystem::path& file,
                             const std::function<bool(double work)>& go_on);

}  // namespace weft
