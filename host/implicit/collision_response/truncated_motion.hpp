#pragma once

#include <vector>

#include "host/implicit/collision_response/separating_planes.hpp"
#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"
#include "weft/state/contact.hpp"
#include "weft/state/moved_vertex.hpp"

namespace weft {

/// How a truncated motion avoids its collisions.
enum class TruncationKind {
  /// Ends stay on their sides of separating planes, see SeparatingPlanes. After some rounds
  /// prescribed vertices as well, and after some more, vertices that still collide end at a share
  /// of
  /// their way. For prescribed motions that are short against edges: directions are fixed.
  planes,
  /// Free vertices that collide form clusters. A free vertex may end at any share of the way
  /// between
  /// riding along with its cluster and its own target. A cluster rides with the prescribed vertices
  /// that run into it: with the fastest of them, and on top of that out of the way of the others.
  /// The rounds shorten, in this order: free vertices; prescribed ones too; the free vertices of
  /// whole clusters, which then only ride.
  rides,
  /// What collides, prescribed or not, ends at a share of its way.
  shares,
};

/// Shortens a motion until it is free of collisions. Its start is free, so this always succeeds: at
/// worst nothing moves. The caller detects collisions along straight lines and hands them over,
/// round after round, until there are none. What still collides after the rounds of a kind stays
/// where it started.
///
/// The outcome depends on the collisions of each round and on their order, on nothing else.
template <class T>
class TruncatedMotion {
 public:
  /// After so many rounds nothing moves, and no collision can be left.
  static constexpr int rounds_max = 64;

  /// @param from      [vertices] [m] start, free of collisions
  /// @param to        [vertices] [m] targets
  /// @param held      [vertices] 1: prescribed
  /// @param thickness [m]
  void begin(std::vector<Vec3<T>> from, std::vector<Vec3<T>> to,
             const std::vector<unsigned char>& held, TruncationKind kind, double thickness);

  /// One more round.
  /// @param collisions of the motion as the round before left it; not empty
  /// @return           the vertices that end elsewhere now; valid until the next call
  const std::vector<MovedVertex<T>>& shorten(Span<const Collision> collisions);

  /// [vertices] [m]
  const std::vector<Vec3<T>>& targets() const noexcept { return to_; }

 private:
  /// A collision of a cluster with something prescribed: with u the cluster's ride, the gap grows
  /// by weight * n . u + approach.
  struct Carrier {
    Index cluster;              ///< some vertex of it
    Vec3<double> displacement;  ///< [m] of the fastest prescribed vertex
    Vec3<double> n;
    double weight;
    double approach;  ///< [m]
  };

  Index cluster_of(Index v);
  void join(Span<const Collision> collisions);
  void find_rides();
  void limit(Span<const Collision> collisions);
  void keep_planes(Span<const Collision> collisions);
  Vec3<T> end_of(std::size_t v);
  void find_moved();

  std::vector<Vec3<T>> from_, to_, end_;
  std::vector<unsigned char> held_;
  std::vector<T> own_share_;        ///< [vertices] from the cluster's ride, 0, to the target, 1
  std::vector<T> share_;            ///< [vertices] of the way from the start to that
  std::vector<Index> cluster_;      ///< [vertices] towards the first vertex of the cluster
  std::vector<Vec3<double>> ride_;  ///< [vertices] [m] of the cluster that the vertex is first of
  std::vector<Carrier> carriers_;
  SeparatingPlanes<T> planes_;
  std::vector<MovedVertex<T>> moved_;
  TruncationKind kind_ = TruncationKind::rides;
  int round_ = 0;
};

}  // namespace weft
