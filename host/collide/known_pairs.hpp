#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"
#include "weft/elements/scalar.hpp"
#include "weft/kernels/collide/proximity.hpp"
#include "weft/state/known_distances.hpp"

namespace weft {

/// Skips pairs whose known distance shows that they cannot be contacts. Two primitives close by at
/// most the distance between the centres of their displacement balls plus both radii. That is never
/// less than PairLanes::closing(), so a skipped pair would not have become a contact. Before that
/// is computed, a pair is compared with the most that any two primitives close.
template <class T>
class KnownPairs {
 public:
  explicit KnownPairs(const CollideProximity<T>& args)
      : a_(args),
        vertices_(args.known.motions.data()),
        edges_(vertices_ + args.positions_t0.size()),
        faces_(edges_ + args.surface.edges.size()),
        holds_(args.known.hold) {
    if (!holds_ && a_.known.faces.empty()) return;
    T size = T(0);
    for (std::size_t v = 0; v < a_.positions_t0.size(); ++v)
      for (int c = 0; c < 3; ++c)
        size = std::max({size, std::fabs(a_.positions_t0[v][c]), std::fabs(a_.positions_t1[v][c])});
    rounding_ = T(8) * epsilon<T> * size;
    if (!holds_) return;
    find_motions();
    closed_before_ = a_.known.closed[0];
    closed_ = above(closed_before_ + most_closing(&PrimitiveMotion<T>::before));
    const float ahead = most_closing(&PrimitiveMotion<T>::ahead);
    closed_ahead_ = above(closed_ + (ahead + static_cast<float>(rounding_)));
    far_ = above(closed_ahead_ + (0.01f * ahead + 1.0001f * static_cast<float>(a_.thickness)));
  }

  /// Whether a pair is certainly no contact, whatever its primitives have done.
  /// @param bound [m] the pair's separation bound, valid where it is passed over
  template <int First>
  bool is_far(std::size_t number, float& bound) const {
    if (!holds_) return false;
    const float known = distances<First>()[number];
    bound = 0.9999f * (known - closed_ahead_);
    return known > far_;
  }

  /// Whether a pair is certainly no contact. Lowers its known distance by what its primitives can
  /// have closed since. That falls short of the distance for ever once cloth has come to rest, and
  /// most pairs would not be far: so each is measured in one of `turns` calls all the same.
  /// @param bound [m] as above
  template <int First>
  bool passes_over(const Pair& pair, std::size_t number, float& bound) {
    if (!holds_) return false;
    float& known = distances<First>()[number];
    const PrimitiveMotion<T>& p = (First == 1 ? vertices_ : edges_)[pair.a];
    const PrimitiveMotion<T>& q = (First == 1 ? faces_ : edges_)[pair.b];
    // Rounded down: cloth at rest keeps its bounds for thousands of steps.
    const T distance = below(known - closed_before_) - T(1.0001) * closing(p.before, q.before);
    known = kept(static_cast<float>(distance));
    const T ahead = closing(p.ahead, q.ahead);
    // Not "<": where something is not a number the pair has to be measured.
    if (!(distance - T(1.01) * ahead > T(1.0001) * a_.thickness + rounding_)) return false;
    if ((number + a_.known.turn) % turns == 0) return false;
    bound = static_cast<float>(distance - T(1.0001) * ahead - rounding_);
    return true;
  }

  /// @param distance [m] lower bound at the start
  template <int First>
  void keep(std::size_t number, T distance) {
    if (!a_.known.faces.empty())
      distances<First>()[number] = kept(static_cast<float>(T(0.9999) * distance - rounding_));
  }

  /// To be called when all pairs have been passed over or measured.
  void finish() {
    if (a_.known.faces.empty()) return;
    std::copy_n(a_.positions_t0.data(), a_.positions_t0.size(), a_.known.positions.data());
    a_.known.closed[0] = closed_;
  }

 private:
  static constexpr std::size_t turns = 16;

  template <int First>
  float* distances() const {
    return (First == 1 ? a_.known.faces : a_.known.edges).data();
  }

  /// Less, or more, by more than the rounding of a sum.
  static float below(float x) { return x - 2 * epsilon<float> * std::fabs(x); }
  static float above(float x) { return x + 2 * epsilon<float> * std::fabs(x); }
  /// A distance as it is kept.
  float kept(float distance) const { return below(distance + closed_); }

  /// [m] Most that a primitive of cloth and any other one close: by the largest displacements of
  /// vertices about the mean of cloth. Not a number if any is not.
  float most_closing(DisplacementBall<T> PrimitiveMotion<T>::*which) const {
    const auto cloth = static_cast<std::size_t>(a_.cloth_vertex_count);
    Vec3<T> mean{};
    for (std::size_t v = 0; v < cloth; ++v) mean += (vertices_[v].*which).centre;
    mean = (T(1) / static_cast<T>(cloth)) * mean;
    T most[2] = {};  // of cloth, of obstacles
    for (std::size_t v = 0; v < a_.positions_t0.size(); ++v) {
      const T d = length_sq((vertices_[v].*which).centre - mean);
      T& m = most[v < cloth ? 0 : 1];
      if (d > m || std::isnan(d)) m = d;
    }
    const T of_cloth = std::sqrt(most[0]), of_obstacles = std::sqrt(most[1]);
    const T of_other = of_obstacles < of_cloth ? of_cloth : of_obstacles;
    return static_cast<float>(T(1.0002) * (of_cloth + of_other) + T(8) * epsilon<T> * length(mean));
  }

  static T closing(const DisplacementBall<T>& p, const DisplacementBall<T>& q) {
    return length(p.centre - q.centre) + p.radius + q.radius;
  }

  void find_motions() {
    const Vec3<T>* x = a_.positions_t0.data();
    for (std::size_t v = 0; v < a_.positions_t0.size(); ++v)
      vertices_[v] = {{x[v] - a_.known.positions[v], T(0)}, {a_.positions_t1[v] - x[v], T(0)}};
    for (std::size_t e = 0; e < a_.surface.edges.size(); ++e)
      edges_[e] = around<2>(a_.surface.edges[e].v);
    for (std::size_t f = 0; f < a_.triangles.size(); ++f) faces_[f] = around<3>(a_.triangles[f].v);
  }
  template <int Corners>
  PrimitiveMotion<T> around(const Index* v) const {
    return {ball<Corners>(v, &PrimitiveMotion<T>::before),
            ball<Corners>(v, &PrimitiveMotion<T>::ahead)};
  }
  template <int Corners>
  DisplacementBall<T> ball(const Index* v, DisplacementBall<T> PrimitiveMotion<T>::*which) const {
    DisplacementBall<T> ball{{}, T(0)};
    for (int j = 0; j < Corners; ++j) ball.centre += (vertices_[v[j]].*which).centre;
    ball.centre = (T(1) / Corners) * ball.centre;
    T most = T(0);
    for (int j = 0; j < Corners; ++j)
      most = std::max(most, length_sq((vertices_[v[j]].*which).centre - ball.centre));
    ball.radius = std::sqrt(most);
    return ball;
  }

  const CollideProximity<T>& a_;
  PrimitiveMotion<T>* vertices_;
  PrimitiveMotion<T>* edges_;
  PrimitiveMotion<T>* faces_;
  T rounding_ = T(0);  ///< [m] of what is computed from positions
  bool holds_;
  float closed_before_ = 0;  ///< [m] KnownDistances::closed as the call before has left it
  float closed_ = 0;         ///< [m] the same from now on
  float closed_ahead_ = 0;   ///< [m] that, and what any two primitives close in the prediction
  float far_ = 0;            ///< [m] a pair known to be farther apart is passed over
};

}  // namespace weft
