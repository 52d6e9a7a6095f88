#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

#include "weft/core/hd.hpp"
#include "weft/core/ids.hpp"
#include "weft/core/marks.hpp"
#include "weft/core/span.hpp"
#include "weft/elements/ccd.hpp"
#include "weft/elements/contact.hpp"
#include "weft/elements/pair_lanes.hpp"
#include "weft/elements/scalar.hpp"
#include "weft/exec/launch.hpp"
#include "weft/kernels/collide/out_of_bounds.hpp"
#include "weft/kernels/collide/pairs.hpp"
#include "weft/kernels/collide/proximity.hpp"
#include "weft/state/contact.hpp"

namespace weft {

/// Continuous detection over the step, in double whatever the precision of the run: a pair collides
/// if its distance falls below `separation` (or half of its distance at the start, if that is
/// less). Also checks that every vertex kept to its swept AABB, without which the pairs are not
/// all. First round: all pairs. Later rounds: pairs of which a vertex has moved since. Reads:
/// pairs, positions. Writes: collisions, counts. Order: as the pairs. Ghosts: all vertices. Flags:
/// out_of_bounds, not_finite, counts above capacity. If a vertex is out of bounds, and with
/// `stop_at_missed` where a collision of no contact is found, the rest may be left out: only that
/// it is so counts.
template <class T>
struct CollideContinuous {
  Span<const Pair> face_pairs;  ///< capacity; the number stands in counts
  Span<const Pair> edge_pairs;
  Span<const float> face_separation_bound;  ///< [capacity] [m] as CollideProximity left it
  Span<const float> edge_separation_bound;
  Span<const Edge> edges;
  Span<const Tri> triangles;
  Span<const Vec3<T>> positions_t0;  ///< [vertices] [m]
  Span<const Vec3<T>> positions_t1;  ///< [vertices] [m]
  Span<const Vec3<T>> predicted;     ///< [vertices] [m] the positions_t1 of the separation bounds
  Span<float> deviation;             ///< [vertices] scratch [m] from the prediction
  Span<const BoxOf<T>> swept_aabb;   ///< [vertices]
  Span<const unsigned char> moved;   ///< [vertices] since the last round; empty: first round
  /// This rank's share of cloth and obstacle (which may yield), checked against their swept AABBs.
  Index vertex_begin = 0, vertex_end = 0;
  double separation;           ///< [m] under which a pair collides
  double offset;               ///< [m] gap that the response restores
  Span<Collision> collisions;  ///< capacity
  Span<CollideCounts> counts;  ///< [1]
  bool stop_at_missed = false;
  Span<std::uint32_t> scratch;  ///< [continuous_scratch_size] in CUDA; not in use on the host
};

/// Numbers of scratch that CollideContinuous takes in CUDA.
/// @param face_pairs, edge_pairs capacities
constexpr std::size_t continuous_scratch_size(std::size_t face_pairs,
                                              std::size_t edge_pairs) noexcept {
  return 3 * marks_size(face_pairs + edge_pairs + 2 * Marks::word_items);
}

template <class T>
void run(OnHost, Queue& queue, const CollideContinuous<T>& args);
template <class T>
void run(OnCuda, Queue& queue, const CollideContinuous<T>& args);

/// The decisions of CollideContinuous, a vertex or a pair at a time. The three of a pair follow
/// each other, the cheap ones first; each passes on all that can collide.
/// @tparam First corners of the first primitive: 1 vertex and face, 2 two edges
template <class T>
class ContinuousRule {
 public:
  WEFT_HD explicit ContinuousRule(const CollideContinuous<T>& args) noexcept : a_(args) {}

  /// Components of a vertex's end that are not finite.
  WEFT_HD int not_finite(Index v) const noexcept {
    using std::fabs;
    int count = 0;
    for (int c = 0; c < 3; ++c)
      if (!(fabs(a_.positions_t1.data()[v][c]) <= std::numeric_limits<T>::max())) ++count;
    return count;
  }

  WEFT_HD bool out_of_bounds(Index v) const noexcept {
    return !keeps_to(a_.swept_aabb.data()[v], a_.positions_t1.data()[v]);
  }

  /// How far a vertex ends from where it was predicted, rounding included. [m]
  WEFT_HD float deviation(std::size_t v) const noexcept {
    using std::fabs;
    const Vec3<T>& x = a_.positions_t1.data()[v];
    const T size = greater(fabs(x[2]), greater(fabs(x[1]), fabs(x[0])));
    return static_cast<float>(T(1.0001) * length(x - a_.predicted.data()[v]) +
                              T(8) * epsilon<T> * size);
  }

  template <int First>
  WEFT_HD void corners(std::size_t number, Index v[4]) const noexcept {
    if constexpr (First == 1) {
      const Pair& p = a_.face_pairs.data()[number];
      v[0] = p.a;
      for (int j = 0; j < 3; ++j) v[j + 1] = a_.triangles.data()[p.b].v[j];
    } else {
      const Pair& p = a_.edge_pairs.data()[number];
      for (int j = 0; j < 2; ++j) {
        v[j] = a_.edges.data()[p.a].v[j];
        v[j + 2] = a_.edges.data()[p.b].v[j];
      }
    }
  }
  template <int First>
  WEFT_HD float separation_bound(std::size_t number) const noexcept {
    return (First == 1 ? a_.face_separation_bound : a_.edge_separation_bound).data()[number];
  }

  /// Whether a separation bound keeps a pair apart. Not where something is not a number.
  /// @param deviation [m] from the prediction, of both primitives together
  WEFT_HD bool is_apart(float separation_bound, float deviation) const noexcept {
    return separation_bound - 1.0001f * deviation > static_cast<float>(a_.separation) * 1.0001f;
  }

  /// Whether the separation bound does not keep a pair apart, and something of it has moved.
  template <int First>
  WEFT_HD bool has_to_be_looked_at(const Index v[4], float separation_bound) const noexcept {
    const float* d = a_.deviation.data();
    const float deviation = First == 1 ? d[v[0]] + greater(d[v[3]], greater(d[v[2]], d[v[1]]))
                                       : greater(d[v[1]], d[v[0]]) + greater(d[v[3]], d[v[2]]);
    if (is_apart(separation_bound, deviation)) return false;
    const unsigned char* moved = a_.moved.data();
    return a_.moved.empty() || (moved[v[0]] | moved[v[1]] | moved[v[2]] | moved[v[3]]) != 0;
  }

  /// Whether boxes and planes, or the distance, at the start do not keep each pair apart either.
  template <int First, int Width>
  WEFT_HD void may_collide(const PairLanes<T, First, Width>& lanes,
                           bool out[Width]) const noexcept {
    T closing[Width];
    T reach[Width];
    T gap[Width];
    T plane_gap[Width];
    lanes.closing(closing);
    // Displacements round at the size of the coordinates; a hundredth on top covers the rest.
    for (int k = 0; k < Width; ++k)
      reach[k] = T(1.0001) * static_cast<T>(a_.separation) + T(1.01) * closing[k] +
                 T(8) * epsilon<T> * lanes.size(k);
    lanes.box_gap(gap);
    lanes.plane_gap(plane_gap);
    for (int k = 0; k < lanes.count(); ++k)
      out[k] = !(gap[k] > reach[k] || plane_gap[k] > reach[k] ||
                 farther<First>(lanes.corners(k), reach[k]));
  }

  /// The certified test, in double.
  /// @param c written where the pair collides
  template <int First>
  WEFT_HD bool collides(const Index v[4], Collision& c) const noexcept {
    using std::sqrt;
    Vec3<double> x_t0[4];
    Vec3<double> x_t1[4];
    for (int j = 0; j < 4; ++j) {
      x_t0[j] = vec_cast<double>(a_.positions_t0.data()[v[j]]);
      x_t1[j] = vec_cast<double>(a_.positions_t1.data()[v[j]]);
    }
    const Proximity<double> start = closest_points<First>(x_t0);
    const double distance = sqrt(start.distance_sq);
    const double separation = lesser(0.5 * distance, a_.separation);
    const Impact<double> impact = detail::ccd<First>(x_t0, x_t1, separation, 0.0);
    if (!impact.hit) return false;
    const Vec3<double> at_start =
        distance > 0 ? (1 / distance) * start.difference : Vec3<double>{0, 0, 1};
    c.n = contact_normal(impact.at.difference, at_start);
    for (int j = 0; j < 4; ++j) {
      c.v[j] = v[j];
      c.w[j] = impact.at.w[j];
    }
    // Less than there was, or zones would have to make room that there may not be; but layers that
    // are pinched step after step must not come as close as rounding, where nothing parts them.
    c.offset = lesser(greater(0.05 * a_.offset, 0.9 * distance), a_.offset);
    c.toi = impact.toi;
    return true;
  }

 private:
  /// Whether the distance at the start is larger than `reach`, rounding included.
  template <int First>
  WEFT_HD bool farther(const Index v[4], T reach) const noexcept {
    using std::sqrt;
    Vec3<T> x[4];
    for (int j = 0; j < 4; ++j) x[j] = a_.positions_t0.data()[v[j]];
    return T(0.9999) * sqrt(closest_points<First>(x).distance_sq) > reach;
  }

  const CollideContinuous<T>& a_;
};

}  // namespace weft
