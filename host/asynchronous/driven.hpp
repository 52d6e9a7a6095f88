#pragma once

#include <vector>

#include "host/asynchronous/histories.hpp"
#include "host/model/model.hpp"

namespace weft {

/// Obstacles that a torque and the cloth turn about an axis. Between two ticks of a bucket of their
/// own they turn evenly, as if of infinite mass, and what layers and pinned cloth give them is
/// summed up; at the tick they take it:
///   speed += (torque h + impulse) / inertia,  angle += speed (next - now)
class DrivenBodies {
 public:
  /// @param place [vertices of the model] their numbers in VertexMotion
  /// @param scene, model must outlive this
  DrivenBodies(const Scene& scene, const Model& model, const std::vector<Index>& place);

  bool any() const { return !bodies_.empty(); }

  /// Bodies as they are at the start, and which vertices they carry.
  /// @param state [3 a body] angle [rad], speed [rad/s], impulse [N m s]; empty: at rest
  void begin(const std::vector<double>& state, VertexMotion& motion) const;
  /// The state that begin() takes.
  static std::vector<double> state_of(const VertexMotion& motion);

  /// Bodies take at `now` what they have been given, torque and the weight of what is pinned to
  /// them, and are to turn until `next`.
  /// @param h [s] that torque and weight act for: next - now, half of it in the beginning
  void turn(double now, double next, double h, VertexMotion& motion) const;

  /// From `now` on all that they carry moves so that it is in its place at `next`.
  /// @param histories null: nothing is recorded
  void carry(double now, double next, VertexMotion& motion, Histories* histories) const;

 private:
  struct Carried {
    std::size_t place;  ///< in VertexMotion
    std::size_t body;
    Vec3<double> start;  ///< [m] from the body's origin, before it has turned
    double mass;         ///< [kg] of pinned cloth; 0: part of the body
    double inertia;      ///< [kg m^2] of that mass about the axis
  };

  const DrivenBody& body(std::size_t b) const { return *scene_.obstacles[bodies_[b]].driven; }

  const Scene& scene_;
  std::vector<std::size_t> bodies_;  ///< into the scene's obstacles
  std::vector<Carried> carried_;
  std::vector<Index> carrier_;  ///< [vertices] as in VertexMotion
};

}  // namespace weft
