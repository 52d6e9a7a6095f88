#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "host/implicit/contact/broad_phase.hpp"
#include "weft/core/ids.hpp"
#include "weft/core/vec.hpp"
#include "weft/exec/device.hpp"

namespace weft {

/// A mesh at two times. Vertices are ordered along a Morton curve, triangles and edges by their
/// lowest vertex, as in a Model, so that consecutive primitives are close in space.
struct SweptMesh {
  std::vector<Vec3<double>> positions_t0;  ///< [vertices] [m]
  std::vector<Vec3<double>> positions_t1;  ///< [vertices] [m]
  std::vector<Tri> triangles;
  std::vector<Edge> edges;  ///< each once
  PrimitiveCounts counts;   ///< all cloth, unless the caller appends an obstacle
};

/// @param positions_t0 [vertices] [m] finite, not empty
/// @param positions_t1 [vertices] [m] finite, of the same length
/// @param triangles    corners below the number of vertices
SweptMesh make_swept_mesh(const std::vector<Vec3<double>>& positions_t0,
                          const std::vector<Vec3<double>>& positions_t1,
                          const std::vector<Tri>& triangles);

/// The broad phase alone, as a simulation launches it, for tests and benchmarks.
template <class T>
class SweptSearch {
 public:
  /// @param inflate [m] by which every box grows on all sides
  /// @param margin  [m] by which vertices may leave the motion and stay inside their boxes
  /// @param split_motion [m] see CollideBoxes; default: never split
  SweptSearch(DeviceSet& devices, const SweptMesh& mesh, double inflate, double margin = 0,
              double split_motion = std::numeric_limits<double>::infinity());

  /// Sets another motion for later runs. [vertices] [m]
  void move(const std::vector<Vec3<double>>& positions_t0,
            const std::vector<Vec3<double>>& positions_t1);

  /// Searches, and repeats the search with longer lists if they were too short. Waits for the
  /// ranks.
  void run();

  /// Pairs of the latest run, of all ranks. Numbers are those of the SweptMesh.
  std::vector<Pair> face_pairs() const;
  std::vector<Pair> edge_pairs() const;

  std::int64_t face_pair_count() const;
  std::int64_t edge_pair_count() const;
  /// Number of non-empty cells in the spatial hashes of faces and edges.
  std::int64_t cell_count() const;
  /// Box tests of the latest run. [ranks]
  std::vector<std::int64_t> tests() const;

 private:
  struct Rank {
    Buffer<Vec3<T>> positions_t0, positions_t1;
    Buffer<Tri> triangles;
    Buffer<Edge> edges;
    Buffer<Pair> face_pairs, edge_pairs;
    Buffer<CollideCounts> counts;
  };

  void launch_pairs(int r);
  void read_counts();
  bool grow_where_full();
  std::vector<Pair> joined(Buffer<Pair> Rank::*list, Index CollideCounts::*count) const;

  DeviceSet& devices_;
  T inflate_;
  T margin_;
  T split_motion_;
  BroadPhase<T> broad_phase_;
  std::vector<Rank> ranks_;
  std::vector<CollideCounts> counts_;  ///< [ranks]
};

}  // namespace weft
