#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <vector>

#include "host/model/model.hpp"
#include "host/state/checkpoint.hpp"
#include "host/time_parallel/coarse_scene.hpp"

namespace weft {

/// States of the coarse run, of which each step leaves a checkpoint in a directory, and the same on
/// fine meshes. Where the coarse run remeshes, each has meshes of its own.
class CoarseStates {
 public:
  /// On the meshes of the fine scene that the level was made of.
  /// @param level must outlive this   @pre the coarse run does not remesh
  CoarseStates(const CoarseScene& level, std::filesystem::path directory);

  /// On any meshes of the fine scene's cloths.
  /// @param fine must outlive this too
  CoarseStates(const CoarseScene& level, std::filesystem::path directory, const Scene& fine);

  /// Name of the checkpoint after a number of coarse steps.
  static std::filesystem::path file(const std::filesystem::path& directory, std::int64_t step);

  /// Whether that is there, whole: a power cut may have damaged it.
  static bool there(const std::filesystem::path& directory, std::int64_t step) {
    return whole_checkpoint(file(directory, step));
  }

  /// The state of the coarse run at a time between two of its steps, on the fine meshes: positions
  /// and velocities linear in material space, and in between (Liang & Lin 2018, section 5.4).
  /// @param time [s] >= 0, not beyond the last checkpoint
  /// @throws SceneError if a checkpoint is missing or damaged
  InputState fine_state(double time);

  /// The coarse level as it is at that time, or at the last step before: its meshes, and where the
  /// vertices of the fine ones lie in them.
  CoarseScene level_at(double time);

  /// Largest energy of motion at the ends of the coarse run's frames until a time. [J]
  double peak_kinetic(double time);

  double step_length() const { return step_; }  ///< [s]

 private:
  /// The level with the meshes of some states, and the order of the coarse vertices in these.
  struct Meshes {
    CoarseScene level;
    Model model;
  };
  struct Known {
    std::shared_ptr<const Meshes> meshes;
    InputState coarse;
    double peak_kinetic = 0;  ///< [J] where the coarse run remeshes: at its last remesh
  };
  /// A time as a place between two steps.
  struct Place {
    std::int64_t step;
    double share;  ///< of the step after it
  };
  Place place_of(double time) const;
  const Known& state(std::int64_t step);
  Known read(std::int64_t step);
  std::shared_ptr<const Meshes> meshes_like(Scene scene) const;
  template <class T>
  InputState read_inputs(std::int64_t step, const Meshes& meshes) const;

  std::filesystem::path directory_;
  double step_;
  const CoarseScene& begun_;              ///< the level as the coarse run begins
  const Scene* fine_;                     ///< null: the meshes that the level was made of
  std::uint64_t origin_ = 0;              ///< of a coarse run that remeshes
  std::shared_ptr<const Meshes> meshes_;  ///< of the latest state that was read
  std::map<std::int64_t, Known> states_;  ///< the last few that were asked for
};

/// Tracking constraints, see make_tracking(), with the coarse run for their target.
/// @param level of the fine scene's meshes as they are
std::shared_ptr<Tracking> tracking_of(const Scene& fine, const CoarseScene& level,
                                      std::shared_ptr<CoarseStates> states);

}  // namespace weft
