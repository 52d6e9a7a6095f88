#pragma once

#include <vector>

#include "host/implicit/linear/linear_system.hpp"
#include "host/state/rank_geometry.hpp"
#include "host/state/store.hpp"
#include "weft/report.hpp"
#include "weft/state/moved_vertex.hpp"

namespace weft {

/// Moves obstacles and pinned vertices to where the scene puts them, and measures by how much cloth
/// in between keeps them from there.
template <class T>
class PrescribedMotion {
 public:
  PrescribedMotion(Store<T>& store, std::vector<RankGeometry<T>>& geometry,
                   std::vector<RankMotion<T>>& motion, LinearSystem<T>& system);

  /// Sets obstacles and pinned vertices at the end of the motion, as they are at `time`.
  void place(double time);

  /// [vertices] 1 if the position is prescribed, see fixed_vertices()
  const std::vector<unsigned char>& fixed() const noexcept { return fixed_; }
  /// [obstacle vertices] [m] where place() has put them
  const std::vector<Vec3<double>>& placed() const noexcept { return placed_; }

  /// How far the farthest prescribed vertex is to move. [m]
  double farthest() const;

  /// Prescribed vertices that end the attempt short of their targets.
  struct Misses {
    int count = 0;
    double distance = 0;        ///< [m] at most
    double farther = 0;         ///< [m] than at the start, at most
    double over_limit = 0;      ///< distance over what is allowed, at most
    std::vector<Index> over;    ///< vertices that exceed what is allowed
    Index worst = -1;           ///< vertex of over_limit
    double worst_distance = 0;  ///< [m] its distance
  };
  Misses misses() const;
  /// Fails a step of length dt because of them.
  /// @return false
  bool fail_by(const Misses& misses, double dt, StepReport& report) const;

 private:
  Store<T>& store_;
  std::vector<RankGeometry<T>>& geometry_;
  std::vector<RankMotion<T>>& motion_;
  LinearSystem<T>& system_;
  std::vector<unsigned char> fixed_;     ///< as uploaded
  std::vector<MovedVertex<T>> targets_;  ///< of pinned vertices
  std::vector<Buffer<MovedVertex<T>>> rank_targets_;
  std::vector<Vec3<double>> placed_;
  std::vector<Vec3<T>> placed_rounded_;
};

}  // namespace weft
