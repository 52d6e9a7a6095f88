#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/asynchronous/histories.hpp"
#include "host/asynchronous/workers.hpp"
#include "weft/core/ids.hpp"
#include "weft/elements/distance.hpp"

namespace weft {

/// Thickness, stiffness and step of the nested penalty layers l = 1, 2, ...:
///   eta(l) = eta(1) l^(-1/4),  r(l) = r(1) l^3,  h(l) = h(1) l^(-3/2)
/// The energies r(l) / 2 (eta(l) - d)^2 of all layers sum to infinity as the distance d vanishes.
/// @cite harmon2009
struct LayerRule {
  double thickness;  ///< [m] eta(1)
  double stiffness;  ///< [N/m] r(1)
  double step;       ///< [s] h(1)

  double thickness_of(int l) const { return thickness / std::sqrt(std::sqrt(double(l))); }
  double stiffness_of(int l) const { return stiffness * (double(l) * l * l); }
  double step_of(int l) const { return step / (double(l) * std::sqrt(double(l))); }

  /// How many layers a distance lies within: those with eta(l) > d, `most` at most.
  int layers_within(double d, int most) const;
};

/// A vertex and a face, or two edges, by the numbers of vertices, and of what they are.
struct PrimitivePair {
  std::uint64_t key;  ///< kind, then the number of the first and of the second primitive
  Index v[4];         ///< corners: those of the first primitive first

  static constexpr std::uint64_t edges = std::uint64_t{1} << 63;
  static std::uint64_t key_of(bool of_edges, Index first, Index second) {
    return (of_edges ? edges : 0) | (static_cast<std::uint64_t>(first) << 32) |
           static_cast<std::uint64_t>(second);
  }
  bool of_edges() const { return (key & edges) != 0; }
  int first_count() const { return of_edges() ? 2 : 1; }
  Proximity<double> closest(const Vec3<double> x[4]) const {
    return of_edges() ? edge_edge(x) : vertex_triangle(x);
  }
};

/// A pair with the number of layers that act on it.
struct LayeredPair {
  PrimitivePair pair;
  int depth;
  /// Unit, or zero: across which the two were last seen apart. Saves work, changes no result.
  Vec3<double> across{};
};

/// Impulse of one layer on one pair.
struct LayerImpulse {
  std::uint32_t pair;     ///< number in the layer's list
  double normal;          ///< [N s] along n, pushing apart
  Vec3<double> n;         ///< unit, from the second primitive to the first
  double w[4];            ///< weights of the corners, as in Proximity
  Vec3<double> friction;  ///< [N s] likewise, across n
};

/// What a tick of a layer did.
struct LayerTick {
  std::int64_t pairs = 0;   ///< that were looked at
  std::int64_t acting = 0;  ///< that were within the layer
};

/// The constants that layers act by.
struct LayerForces {
  LayerRule rule;
  double restitution;            ///< [0, 1] of velocity
  std::vector<double> friction;  ///< [vertices] Coulomb; pairs take the obstacle's. Empty: none
  Index cloth_count = 0;         ///< vertices below this are cloth
};

/// The penalty layers that are active: for each pair how many, and for each layer its pairs, both
/// in the order of keys. Which layers are active beyond those that act changes no result: a layer
/// that a pair is not within leaves its vertices alone.
class ActiveLayers {
 public:
  /// Layers of a pair, 0 if it has none.
  int depth(std::uint64_t key) const {
    const std::uint32_t number = number_of(key);
    return number == none ? 0 : pairs_[number].depth;
  }
  const std::vector<LayeredPair>& pairs() const { return pairs_; }
  /// Most layers that a pair has.
  int deepest() const { return static_cast<int>(lists_.size()); }
  std::size_t size_of_layer(int l) const { return lists_[static_cast<std::size_t>(l - 1)].size(); }
  /// Over all layers.
  std::size_t layer_pairs() const;
  /// What lists hold.
  std::size_t bytes() const;

  /// Gives each of the pairs one layer more.
  /// @param found keys are unique
  void deepen(const std::vector<PrimitivePair>& found);
  /// Replaces everything.
  void set(std::vector<LayeredPair> pairs);
  /// The pairs with their layers but for those that exert no force at `time` and are not about to:
  /// 1.1 eta(l) <= distance.
  std::vector<LayeredPair> kept(const LayerRule& rule, const VertexMotion& motion, double time,
                                Workers& workers) const;

  /// Layer l acts for `h`, at `time`: impulses from where vertices are and how they move before
  /// it, then summed a vertex in the order of pairs. Vertices that it changes are advanced, and
  /// their ways recorded.
  /// @param normal [N s] scaled by restitution^2 where the pair separates; friction up to Coulomb's
  ///               limit, and no more than stops the sliding of the pairs that act on a vertex
  LayerTick act(int l, double h, double time, const LayerForces& forces, VertexMotion& motion,
                Histories& histories, Workers& workers);

 private:
  static constexpr std::uint32_t none = ~std::uint32_t{0};

  void list_layers();
  std::size_t slot_of(std::uint64_t key) const {
    return static_cast<std::size_t>((key * 0x9e3779b97f4a7c15) >> slot_shift_);
  }
  /// Number of a pair in pairs_, or none.
  std::uint32_t number_of(std::uint64_t key) const {
    for (std::size_t s = slot_of(key);; s = (s + 1) & (slots_.size() - 1))
      if (slots_[s] == none || pairs_[slots_[s]].pair.key == key) return slots_[s];
  }
  void add_friction(const LayerForces& forces, const std::vector<std::uint32_t>& list,
                    const VertexMotion& motion);

  std::vector<LayeredPair> pairs_;  ///< by key
  /// Numbers in pairs_, each in the first free slot from slot_of(key) on, and none elsewhere: at
  /// least three in four, so that most pairs without layers meet none at once.
  std::vector<std::uint32_t> slots_ = {none, none};
  int slot_shift_ = 63;
  std::vector<std::vector<std::uint32_t>> lists_;  ///< [layers] numbers in pairs_
  std::vector<std::vector<LayerImpulse>> found_;   ///< [threads]
  std::vector<LayerImpulse> impulses_;
  std::vector<int> sharing_;  ///< [vertices] pairs that act on it, in this tick
};

}  // namespace weft
