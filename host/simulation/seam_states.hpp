#pragma once

#include <vector>

#include "host/scene/seams/sewing.hpp"
#include "host/state/store.hpp"
#include "weft/seam_state.hpp"

namespace weft {

/// How far each seam has been sewn.
/// @param as_read seams of the scene before refinement
/// @param sewing  of the store's scene
template <class T>
std::vector<SeamState> seam_states(const std::vector<Seam>& as_read, const Sewing& sewing,
                                   const Store<T>& store);

/// Brings sewing.closed_at to the state of the store, which is that at the end of a step. Seams
/// that do not weld change only at the end of a frame.
template <class T>
void update_closing_times(const std::vector<Seam>& as_read, const Store<T>& store, bool frame_ends,
                          Sewing& sewing);

}  // namespace weft
