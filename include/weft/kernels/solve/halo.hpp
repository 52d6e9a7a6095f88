#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/exec/launch.hpp"
#include "weft/state/contact_operator.hpp"

namespace weft {

/// The vertices of other ranks that this rank's rows multiply: those of the mesh part, found once,
/// and those of the contact part, recomputed whenever contacts change.
/// Reads: links. Writes: ghost, ghost_offset. Order: ascending vertex number,
/// hence by owner. Ghosts: none. Flags: none.
template <class T>
struct SolveHalo {
  int rank = 0;
  Span<const Index> row_begin;   ///< [ranks + 1]
  Span<const Index> mesh_ghost;  ///< ascending
  ContactOperator<T> contact;
  Span<Index> stamp;         ///< [vertices] scratch, all below `epoch` on entry
  Index epoch = 1;           ///< differs in each launch
  Span<Index> ghost;         ///< [vertices] capacity
  Span<Index> ghost_offset;  ///< [ranks + 1] ghosts of each owner
};

template <class T>
void run(OnHost, Queue& queue, const SolveHalo<T>& args);
template <class T>
void run(OnCuda, Queue& queue, const SolveHalo<T>& args);

}  // namespace weft
