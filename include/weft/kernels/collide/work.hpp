#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/exec/launch.hpp"
#include "weft/kernels/collide/boxes.hpp"
#include "weft/kernels/collide/grid.hpp"

namespace weft {

/// Workload tables (P-Cloth section 4.4): how much the queries of each group of clusters will take,
/// counted as the contents of the cells that its hull covers, summed from the first group on. Ranks
/// share the queries by these sums, so that crowded cells are shared out as well.
/// Reads: hulls, grids. Writes: face_work, edge_work. Order: independent, then a scan of integers.
/// Flags: none. Every rank makes the same tables, so that nothing has to be exchanged.
template <class T>
struct CollideWork {
  ClusterList<T> lists[cluster_kinds];
  Grid grids[cluster_kinds];  ///< of faces and edges
  bool self = true;           ///< cloth against cloth
  Span<Offset> face_work;     ///< [groups of vertices, cloth then obstacle, + 1]
  Span<Offset> edge_work;     ///< [groups of the cloth's edges + 1]
};

template <class T>
void run(OnHost, Queue& queue, const CollideWork<T>& args);
template <class T>
void run(OnCuda, Queue& queue, const CollideWork<T>& args);

}  // namespace weft
