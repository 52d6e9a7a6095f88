#pragma once

#include <memory>
#include <string>
#include <utility>

#include "weft/error.hpp"
#include "weft/frame.hpp"
#include "weft/scene.hpp"

namespace weft {

/// Cloth starts intersecting and could not be parted.
class TangledStart : public SceneError {
 public:
  /// @param message see SceneError
  /// @param scene   that was refused
  /// @param left    cloths and obstacles where untangling left them; velocities are empty
  /// @param place   [m] on the longest contour that is left, relative to the origin of `left`
  TangledStart(const std::string& message, Scene scene, Frame left, const Vec3<double>& place)
      : SceneError(message),
        state_(std::make_shared<const State>(State{std::move(scene), std::move(left), place})) {}

  const Scene& scene() const { return state_->scene; }
  const Frame& left() const { return state_->left; }
  const Vec3<double>& place() const { return state_->place; }

 private:
  struct State {
    Scene scene;
    Frame left;
    Vec3<double> place;
  };
  std::shared_ptr<const State> state_;  ///< shared, because copies of exceptions must not throw
};

}  // namespace weft
