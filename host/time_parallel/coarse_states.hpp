#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>

#include "host/scene/checkpoint.hpp"
#include "host/scene/model.hpp"
#include "host/time_parallel/coarse_scene.hpp"

namespace weft {

/// States of the coarse run, of which each step leaves a checkpoint in a directory.
class CoarseStates {
 public:
  /// @param level must outlive this
  CoarseStates(const CoarseScene& level, std::filesystem::path directory);

  /// Name of the checkpoint after a number of coarse steps.
  static std::filesystem::path file(const std::filesystem::path& directory, std::int64_t step);

  /// Whether that is there, whole: a power cut may have damaged it.
  static bool there(const std::filesystem::path& directory, std::int64_t step) {
    return whole_checkpoint(file(directory, step));
  }

  /// The state of the coarse run at a time between two of its steps, positions and velocities
  /// linear in between (Liang & Lin 2018, section 5.4).
  /// @param time [s] >= 0, not beyond the last checkpoint
  /// @throws SceneError if a checkpoint is missing or damaged
  InputState at(double time);

  /// Fine positions at that time: at() upsampled.
  std::vector<Vec3<double>> fine_positions(double time);

  double step_length() const { return step_; }  ///< [s]

 private:
  const InputState& state(std::int64_t step);
  template <class T>
  InputState read(std::int64_t step) const;

  const CoarseScene& level_;
  std::filesystem::path directory_;
  double step_;
  Model model_;
  std::map<std::int64_t, InputState> states_;  ///< the last few that were asked for
};

/// Tracking constraints, see make_tracking(), with the coarse run for their target.
std::shared_ptr<Tracking> tracking_of(const Scene& fine, const CoarseScene& level,
                                      std::shared_ptr<CoarseStates> states);

}  // namespace weft
