#pragma once

#include <vector>

#include "host/asynchronous/histories.hpp"
#include "host/model/model.hpp"

namespace weft {

/// Vertices of infinite mass that move as the scene prescribes: obstacles and pinned vertices,
/// except driven bodies and vertices pinned to these. Their paths are straight between ticks of a
/// bucket of their own.
class Prescribed {
 public:
  /// @param place [vertices of the model] their numbers in VertexMotion
  /// @param scene, model must outlive this
  Prescribed(const Scene& scene, const Model& model, const std::vector<Index>& place);

  /// Whether anything moves, or is let go.
  bool changes() const { return changes_; }

  /// From `now` on every such vertex moves so that it is in its place at `next`; pins that hold no
  /// longer let go of theirs, which go on as they move.
  /// @param histories null: nothing is recorded
  void aim(double now, double next, VertexMotion& motion, Histories* histories);

  /// How many of release_times() have passed.
  std::size_t phase(double time) const;
  const std::vector<double>& release_times() const { return release_times_; }

 private:
  bool driven(const Pin& pin) const;
  void go(Index model_vertex, const Vec3<double>& to, double now, double next, VertexMotion& motion,
          Histories* histories) const;

  const Scene& scene_;
  const Model& model_;
  std::vector<Index> place_;
  bool changes_ = false;
  std::vector<double> release_times_;  ///< [s] ascending, each once
  std::vector<Vec3<double>> placed_;   ///< [obstacle vertices] [m]
};

}  // namespace weft
