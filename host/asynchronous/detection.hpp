#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include "host/asynchronous/chord.hpp"
#include "host/asynchronous/hierarchy.hpp"
#include "host/asynchronous/layers.hpp"
#include "host/asynchronous/narrow.hpp"
#include "host/asynchronous/worker_group.hpp"
#include "host/model/model.hpp"

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
  /// @param any    set as soon as there is one
  std::vector<PrimitivePair> missed(const Histories& trajectories, const VertexMotion& motion,
                                    const ActiveLayers& layers, const LayerRule& rule,
                                    const WorkerGroup& group, std::atomic<bool>& any,
                                    DetectionCounts& counts);

  /// After missed() found none: pairs that would come within eta(k + 1) before as much time again
  /// has passed, if their corners go on as they went on the whole. A layer that they get now spares
  /// a window that is rolled back. In the order of their keys.
  std::vector<PrimitivePair> expected(const LayerRule& rule, Workers& workers) const;

  /// All pairs that are within the first layer at `time`, with the layers that they are within.
  /// @param most layers
  std::vector<LayeredPair> within(const VertexMotion& motion, double time, const LayerRule& rule,
                                  int most, Workers& workers);

 private:
  /// What the broad phase left over.
  struct Candidate {
    PrimitivePair pair;
    int depth;     ///< its layers
    bool missed;   ///< has come within eta(depth + 1)
    double apart;  ///< [m] it has certainly not come closer; zero or less: unknown
  };
  /// What one task of the broad phase has found.
  struct Found {
    std::vector<Candidate> candidates;
    std::int64_t passed_over = 0;  ///< candidates that neither have nor will come within a layer
  };
  /// What the broad phase looks for.
  struct Search {
    const VertexMotion& motion;
    const LayerRule& rule;
    double distance;             ///< [m]
    const ActiveLayers* layers;  ///< null: nobody has any, and there are no chords
  };

  void sweep(const Histories& trajectories, double straight, Workers& workers);
  void collect(const Histories& trajectories, Workers& workers);
  void near(const Search& search, Workers& workers);
  void add_pairs(std::size_t s, std::size_t t, const Search& search, Found& to) const;
  void add_pair(const PrimitivePair& pair, const Dop& a, const Dop& b, const Search& search,
                Found& to) const;
  void look(double share, const Histories& trajectories, const LayerRule& rule,
            const WorkerGroup& group, std::atomic<bool>& any, NarrowCounts& counts,
            std::vector<PrimitivePair>& missed);
  bool expects(const Candidate& candidate, const LayerRule& rule) const;

  bool self_;
  bool slabs_;
  std::vector<Tri> triangles_;          ///< cloth, then obstacle
  std::vector<Edge> edges_;             ///< likewise
  std::vector<Tri> edges_of_;           ///< [triangles]
  std::vector<Index> owner_of_vertex_;  ///< [vertices] the triangle that asks for its pairs
  std::vector<Index> owner_of_edge_;    ///< [edges] likewise
  Hierarchy hierarchy_;
  std::vector<Dop> swept_;                     ///< [vertices]
  std::vector<unsigned char> seen_;            ///< [vertices] by collect()
  std::vector<Chord> chords_;                  ///< [vertices]
  std::vector<Found> found_;                   ///< [tasks] by near()
  std::vector<Candidate*> open_;               ///< candidates whose ways are looked at
  std::vector<Index> corners_;                 ///< of these, each once
  std::vector<std::size_t> first_breakpoint_;  ///< [corners + 1] into breakpoints_
  std::vector<Breakpoint> breakpoints_;
  std::vector<Trajectory> trajectory_;  ///< [vertices] of those corners
  std::vector<Dop> edges_swept_;        ///< [edges]
  double rounding_ = 0;                 ///< [m] of projections
};

}  // namespace weft
