#pragma once

#include <cstdint>
#include <vector>

#include "host/state/rank_geometry.hpp"
#include "host/state/store.hpp"
#include "weft/kernels/assemble/external_work.hpp"
#include "weft/state/contact.hpp"

namespace weft {

/// A motion that a step is about to accept. Spans are in the memory of rank 0.
template <class T>
struct AcceptedMotion {
  double dt = 0;  ///< [s]
  /// [cloth vertices] [m] about which elements have the forces of a single linear solve; empty:
  /// they have those where the solve ended
  Span<const Vec3<T>> linear_about;
  double residual = 0;                      ///< [N s] 2-norm of what Newton's method has left
  const std::vector<unsigned char>* fixed;  ///< [vertices] 1: its position is prescribed
  Span<const Contact<T>> contacts;
  /// [vertices] [m], [cloth vertices] [m/s] where the solve ended, before impact zones
  Span<const Vec3<T>> positions_solved, velocities_solved;
  Span<const Vec3<T>> positions, velocities;  ///< the same where the motion ends
  const std::vector<Collision>* collisions;   ///< that impact zones have resolved
};

/// What bodies, pins, handles, seams, wind, pressure and applied forces give to cloth in a step: an
/// upper bound of their work, so that cloth with more energy than this explains has it from
/// nothing. The forces are those at the end of the step: for what stores a convex energy the step's
/// own loss is then on the side of the bound.
template <class T>
class ExternalWork {
 public:
  ExternalWork(Store<T>& store, const std::vector<RankGeometry<T>>& geometry);

  /// Whether the scene has anything that may ever do work.
  bool any() const { return any_; }

  /// Work in the motion from the state. Waits for rank 0. Does not depend on the number of ranks.
  /// @return [J]
  double of(const AcceptedMotion<T>& motion);

 private:
  using Vectors = std::vector<Vec3<double>>;
  /// The cloth's pinned vertices, and the elements at them.
  struct AtPins {
    std::vector<Index> vertices, triangles, hinges, shapes;
    std::vector<Index> around;  ///< all vertices of these elements, ascending
  };
  struct Springs {
    std::vector<Spring<double>> before, after;
  };
  void find_pins(const std::vector<unsigned char>& fixed);
  Springs find_springs(const AcceptedMotion<T>& motion) const;
  double of_contacts(const AcceptedMotion<T>& motion);
  double of_air(const AcceptedMotion<T>& motion);
  double of_applied_forces(const AcceptedMotion<T>& motion);
  double sum_up(AssembleExternalWork<T> args);
  double of_pins(const AcceptedMotion<T>& motion);
  double of_springs(const Springs& springs, const AcceptedMotion<T>& motion) const;
  double of_zones(const AcceptedMotion<T>& motion);
  void choose(std::vector<Index> vertices);
  void fetch_chosen(Span<const Vec3<T>> from, Vectors& to);
  std::vector<Vec3<T>> fetch(Span<const Index> vertices, Span<const Vec3<T>> from);

  Store<T>& store_;
  const std::vector<RankGeometry<T>>& geometry_;
  std::int64_t restores_ = 0;  ///< of the store, when it was asked last
  bool any_ = false, bodies_ = false, pins_ = false, springs_ = false, air_ = false;
  Buffer<T> pressure_;  ///< [cloth triangles] [Pa]; empty: none
  Buffer<double> partial_;
  std::vector<unsigned char> fixed_;  ///< of at_pins_
  AtPins at_pins_;
  std::vector<Index> chosen_;  ///< vertices that the host looks at
  Buffer<Index> chosen_on_device_;
  Buffer<Index> met_;  ///< vertices of collisions
  Buffer<Vec3<T>> gathered_;
  /// [vertices] at the start, and where the solve ended; right for chosen vertices only
  Vectors x0_, x1_, v0_, v1_, v_end_, linear_about_;
};

}  // namespace weft
