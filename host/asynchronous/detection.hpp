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

/// Counts of one detection.
struct DetectionCounts {
  std::int64_t candidates = 0;  ///< pairs that the broad phase found
  NarrowCounts narrow;
};

/// Finds the pairs that come within their next penalty layer during a window.
class Detection {
 public:
  /// @param place [vertices of the model] their numbers here
  /// @param slabs see comes_within()
  Detection(const Scene& scene, const Model& model, const std::vector<Index>& place, bool slabs);

  /// Rebuilds the hierarchy of triangles for these positions. Changes no result.
  void sort(const std::vector<Vec3<double>>& x) { hierarchy_.build(x); }

  /// Pairs that come within eta(k + 1), where k is their number of active layers. If there are any,
  /// also pairs that come within 1.1 eta(k + 1). In the order of keys. Pairs with a common corner
  /// and pairs that no force can move do not count.
  /// @param motion at the end of the window; tells which vertices are prescribed
  /// @param any    set as soon as one pair is found
  std::vector<PrimitivePair> missed(const Histories& trajectories, const VertexMotion& motion,
                                    const ActiveLayers& layers, const LayerRule& rule,
                                    const WorkerGroup& group, std::atomic<bool>& any,
                                    DetectionCounts& counts);

  /// To be called if missed() found none. Pairs that would come within 1.1 eta(k + 1) in another
  /// window of this length, if their corners continued along their chords. If they get their layer
  /// now, the next window need not be rolled back. In the order of keys.
  std::vector<PrimitivePair> expected(const LayerRule& rule, Workers& workers) const;

  /// All pairs inside the first layer at `time`, with the number of layers that they are inside.
  /// @param most maximum of that number
  std::vector<LayeredPair> within(const VertexMotion& motion, double time, const LayerRule& rule,
                                  int most, Workers& workers);

 private:
  /// A pair that the broad phase found.
  struct Candidate {
    PrimitivePair pair;
    int depth;     ///< its number of active layers
    bool missed;   ///< it came within eta(depth + 1)
    double apart;  ///< [m] lower bound of its distance; not positive: unknown
  };
  /// Result of one task of the broad phase.
  struct Found {
    std::vector<Candidate> candidates;
    std::int64_t passed_over = 0;  ///< candidates that neither came nor will come close
  };
  /// Query of the broad phase.
  struct Search {
    const VertexMotion& motion;
    const LayerRule& rule;
    double distance;             ///< [m]
    const ActiveLayers* layers;  ///< null: no pair has any, and there are no chords
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
  std::vector<Edge> edges_;             ///< cloth, then obstacle
  std::vector<Tri> edges_of_;           ///< [triangles]
  std::vector<Index> owner_of_vertex_;  ///< [vertices] the triangle that finds its pairs
  std::vector<Index> owner_of_edge_;    ///< [edges] the triangle that finds its pairs
  Hierarchy hierarchy_;
  std::vector<Dop> swept_;                     ///< [vertices]
  std::vector<unsigned char> seen_;            ///< [vertices] by collect()
  std::vector<Chord> chords_;                  ///< [vertices]
  std::vector<Found> found_;                   ///< [tasks] by near()
  std::vector<Candidate*> open_;               ///< candidates that the narrow phase tests
  std::vector<Index> corners_;                 ///< of these candidates, each once
  std::vector<std::size_t> first_breakpoint_;  ///< [corners + 1] into breakpoints_
  std::vector<Breakpoint> breakpoints_;
  std::vector<Trajectory> trajectory_;  ///< [vertices] of those corners
  std::vector<Dop> edges_swept_;        ///< [edges]
  double rounding_ = 0;                 ///< [m] bound of the rounding of projections
};

}  // namespace weft
