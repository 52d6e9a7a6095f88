#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/scene/live_shape.hpp"
#include "weft/core/span.hpp"
#include "weft/scene.hpp"

namespace weft {

/// What a program sets while its simulation runs: places of obstacles and pins, gravity, wind,
/// when pins let go, and forces. All but the forces stand in the simulation's scene, and a
/// checkpoint keeps it.
class LiveInputs {
 public:
  LiveInputs() = default;
  /// Gives the scene's live obstacles shapes of their own, in world places. Pins that another
  /// simulation has moved are where they start.
  /// @param scene valid, before choose_origin()
  explicit LiveInputs(Scene& scene);

  /// Targets for the end of the next frame.
  /// @param places [vertices] [m] world places
  /// @throws SceneError if the part cannot be moved, or the places are not as many as its vertices,
  ///         not finite or too far away
  void move(const Scene& scene, const ObstacleId& id, Span<const Vec3<double>> places);
  /// @return whether the pin moves for the first time: stores of the scene have to be made again
  bool move(Scene& scene, const PinId& id, Span<const Vec3<double>> places);

  /// Constant forces on a cloth.
  /// @param forces [vertices] [N] empty: none
  /// @throws SceneError as Simulation::set_forces()
  void set_forces(const Scene& scene, const ClothId& id, Span<const Vec3<double>> forces);
  /// [inputs] [N] of all cloths; empty: none at all
  std::vector<Vec3<double>> forces(const Scene& scene) const;

  /// Begins a frame: targets are reached at its end.
  /// @param start, end [s]
  void begin_frame(double start, double end);

  /// Everything that has been set, for a checkpoint; empty: nothing has.
  std::string bytes(const Scene& scene) const;
  /// Sets what these bytes say, and everything else as it was at the start.
  /// @param bytes may be empty
  /// @param file  for messages
  /// @throws SceneError if they make no sense for this scene
  void read(const std::string& bytes, const std::string& file, Scene& scene);

 private:
  struct Start {
    Vec3<double> gravity{0, 0, 0};
    Wind wind;
    std::vector<double> release_times;                 ///< [pins] [s]
    std::vector<std::vector<Vec3<double>>> obstacles;  ///< [obstacles][vertices] [m] none: not live
  };
  bool changed(const Scene& scene) const;
  bool any_forces() const;

  Start start_;
  std::vector<std::shared_ptr<LiveShape>> obstacles_;  ///< [obstacles] null: not live
  std::vector<std::shared_ptr<LiveShape>> pins_;       ///< [pins] null: has never been moved
  std::vector<std::vector<Vec3<double>>> forces_;      ///< [cloths][vertices] [N] none: empty
};

}  // namespace weft
