#pragma once

#include <cstdint>
#include <vector>

#include "host/asynchronous/hierarchy.hpp"
#include "host/asynchronous/layers.hpp"
#include "host/asynchronous/narrow.hpp"
#include "host/scene/model.hpp"

namespace weft {

/// What a detection did.
struct DetectionCounts {
  std::int64_t candidates = 0;  ///< pairs that the broad phase left over
  NarrowCounts narrow;
};

/// Finds the pairs that come within their next layer while the vertices go their ways.
class Detection {
 public:
  /// @param place [vertices of the model] their numbers here
  /// @param slabs see comes_within()
  Detection(const Scene& scene, const Model& model, const std::vector<Index>& place, bool slabs);

  /// Sorts the triangles for where they are now. Changes no result.
  void sort(const std::vector<Vec3<double>>& x) { hierarchy_.build(x); }

  /// Pairs that come within eta(k + 1), k their active layers, in the order of their keys; if there
  /// are any, those too that come within a tenth more. Left out are pairs with a corner in common
  /// and pairs that no force can move.
  /// @param motion at the end of the histories: says who is prescribed
  std::vector<PrimitivePair> missed(const Histories& ways, const VertexMotion& motion,
                                    const ActiveLayers& layers, const LayerRule& rule,
                                    Workers& workers, DetectionCounts& counts);

  /// All pairs that are within the first layer at `time`, with the layers that they are within.
  /// @param most layers
  std::vector<LayeredPair> within(const VertexMotion& motion, double time, const LayerRule& rule,
                                  int most, Workers& workers);

 private:
  void sweep(const Histories& ways, Workers& workers);
  std::vector<PrimitivePair> near(const VertexMotion& motion, double distance, Workers& workers,
                                  const ActiveLayers* layers, const LayerRule& rule);
  void add_pairs(std::size_t s, std::size_t t, const VertexMotion& motion,
                 const ActiveLayers* layers, const LayerRule& rule,
                 std::vector<PrimitivePair>& to) const;
  void add_pair(const PrimitivePair& pair, const Dop& a, const Dop& b, const VertexMotion& motion,
                const ActiveLayers* layers, const LayerRule& rule,
                std::vector<PrimitivePair>& to) const;

  bool self_;
  bool slabs_;
  std::vector<Tri> triangles_;          ///< cloth, then obstacle
  std::vector<Edge> edges_;             ///< likewise
  std::vector<Tri> edges_of_;           ///< [triangles]
  std::vector<Index> owner_of_vertex_;  ///< [vertices] the triangle that asks for its pairs
  std::vector<Index> owner_of_edge_;    ///< [edges] likewise
  Hierarchy hierarchy_;
  std::vector<Dop> swept_;        ///< [vertices]
  std::vector<Dop> edges_swept_;  ///< [edges]
  double rounding_ = 0;           ///< [m] of projections
};

}  // namespace weft
