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

  /// Number of layers that reach a pair at the distance d: those with eta(l) > d, up to `most`.
  int layers_within(double d, int most) const;
};

/// A vertex and a face, or two edges, with the numbers of primitives and corners.
struct PrimitivePair {
  std::uint64_t key;  ///< kind, number of the first primitive, number of the second
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

/// A pair with its number of active layers.
struct LayeredPair {
  PrimitivePair pair;
  int depth;
  /// Unit normal of a slab that may separate the two, from their last closest points; or zero. It
  /// saves work and changes no result.
  Vec3<double> across{};
};

/// Impulse of one layer on one pair.
struct LayerImpulse {
  std::uint32_t pair;     ///< number in the layer's list
  double normal;          ///< [N s] along n, pushing apart
  Vec3<double> n;         ///< unit, from the second primitive to the first
  double w[4];            ///< weights of the corners, as in Proximity
  Vec3<double> friction;  ///< [N s] perpendicular to n
};

/// Counts of one tick of a layer.
struct LayerTick {
  std::int64_t pairs = 0;   ///< that were tested
  std::int64_t acting = 0;  ///< that were inside the layer
};

/// Constants of the forces of all layers.
struct LayerForces {
  LayerRule rule;
  double restitution;            ///< [0, 1] coefficient of restitution
  std::vector<double> friction;  ///< [vertices] Coulomb; the obstacle's prevails. Empty: none
  Index cloth_count = 0;         ///< vertices below this are cloth
};

/// The active penalty layers: their number for each pair, and the pairs of each layer. Both lists
/// are in the order of keys. A layer exerts no force on a pair outside it, so layers that are
/// active without need change no result.
class ActiveLayers {
 public:
  /// Number of layers of a pair.
  int depth(std::uint64_t key) const {
    const std::uint32_t number = number_of(key);
    return number == none ? 0 : pairs_[number].depth;
  }
  const std::vector<LayeredPair>& pairs() const { return pairs_; }
  /// Largest number of layers of any pair.
  int deepest() const { return static_cast<int>(lists_.size()); }
  std::size_t size_of_layer(int l) const { return lists_[static_cast<std::size_t>(l - 1)].size(); }
  /// Number of pairs, summed over all layers.
  std::size_t layer_pairs() const;
  /// Memory of the lists.
  std::size_t bytes() const;

  /// Adds one layer to each of the pairs.
  /// @param found keys are unique
  void deepen(const std::vector<PrimitivePair>& found);
  /// Replaces all pairs.
  void set(std::vector<LayeredPair> pairs);
  /// The pairs with the layers to keep at `time`: those with 1.1 eta(l) > distance. The others
  /// exert no force, and are unlikely to exert one soon.
  std::vector<LayeredPair> kept(const LayerRule& rule, const VertexMotion& motion, double time,
                                Workers& workers) const;

  /// Does one tick of layer l. Impulses follow from the positions and velocities before the tick.
  /// The sum per vertex is in the order of pairs. Advances the vertices that change, and records
  /// their trajectories. If a pair separates, its normal impulse is scaled by restitution^2.
  /// Friction is limited by Coulomb's law. The pairs at a vertex share a second limit: friction at
  /// most stops their sliding.
  /// @param h    [s] time step of the layer
  /// @param time [s] of the tick
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
  /// Hash table of numbers in pairs_. Each is in the first free slot from slot_of(key) on. At least
  /// three quarters of the slots hold `none`, so a lookup of a pair without layers usually ends at
  /// the first slot.
  std::vector<std::uint32_t> slots_ = {none, none};
  int slot_shift_ = 63;
  std::vector<std::vector<std::uint32_t>> lists_;  ///< [layers] numbers in pairs_
  std::vector<std::vector<LayerImpulse>> found_;   ///< [threads]
  std::vector<LayerImpulse> impulses_;
  std::vector<int> sharing_;  ///< [vertices] number of pairs that act on it in this tick
};

}  // namespace weft
