#include "host/simulation/seam_states.hpp"

#include <algorithm>
#include <cstddef>

#include "host/model/springs.hpp"
#include "weft/core/at.hpp"

namespace weft {
template <class T>
std::vector<SeamState> seam_states(const std::vector<Seam>& as_read, const Sewing& sewing,
                                   const Store<T>& store) {
  const Scene& scene = store.scene();
  const Model& model = store.model();
  std::vector<SeamState> states;
  std::size_t pair = 0;
  std::vector<Vec3<T>> positions;
  if (!sewing.refined && !sewing.complete() && !as_read.empty())
    positions = store.snapshot().positions;
  for (std::size_t s = 0; s < as_read.size(); ++s) {
    const Seam& seam = as_read[s];
    SeamState state;
    for (std::size_t side = 0; side < 2; ++side)
      state.cloths[side] = scene.cloths[at(seam.cloths[side])].name;
    state.pairs = static_cast<std::int64_t>(seam.vertices[0].size());
    state.due =
        seam.weld_distance > 0 && !seam.may_stay_open && seam_strength(seam, store.time) >= 1;
    if (s < sewing.closed_at.size()) state.closed_at = sewing.closed_at[s];
    // Refinement replaces the seams; then all pairs are one vertex.
    for (std::size_t k = 0; !positions.empty() && k < seam.vertices[0].size(); ++k, ++pair) {
      if (sewing.welded[pair] != 0) continue;
      // Remeshing renumbers vertices, so those of the scene as it is now count.
      const Seam& now = scene.seams[s];
      const auto place = [&](std::size_t side) {
        const Index input = model.input_offset[at(now.cloths[side])] + now.vertices[side][k];
        return vec_cast<double>(positions[at(model.to_internal[at(input)])]);
      };
      const double gap = length(place(1) - place(0));
      state.largest_gap = std::max(state.largest_gap, gap);
      if (seam.weld_distance > 0 || gap > contact_thickness(scene.contact)) ++state.open;
    }
    states.push_back(std::move(state));
  }
  return states;
}

template <class T>
void update_closing_times(const std::vector<Seam>& as_read, const Store<T>& store, bool frame_ends,
                          Sewing& sewing) {
  sewing.closed_at.resize(as_read.size());
  const auto update = [&](std::size_t s, bool closed) {
    if (!closed)
      sewing.closed_at[s].reset();
    else if (!sewing.closed_at[s])
      sewing.closed_at[s] = store.time;
  };
  std::size_t pair = 0;
  bool all_weld = true;
  for (std::size_t s = 0; s < as_read.size(); ++s) {
    const std::size_t end = pair + as_read[s].vertices[0].size();
    if (as_read[s].weld_distance > 0)
      update(s, sewing.refined ||
                    std::all_of(sewing.welded.begin() + static_cast<std::ptrdiff_t>(pair),
                                sewing.welded.begin() + static_cast<std::ptrdiff_t>(end),
                                [](unsigned char w) { return w != 0; }));
    else
      all_weld = false;
    pair = end;
  }
  if (all_weld || !frame_ends) return;
  const std::vector<SeamState> states = seam_states(as_read, sewing, store);
  for (std::size_t s = 0; s < states.size(); ++s)
    if (!(as_read[s].weld_distance > 0)) update(s, states[s].open == 0);
}

template std::vector<SeamState> seam_states(const std::vector<Seam>&, const Sewing&,
                                            const Store<float>&);
template std::vector<SeamState> seam_states(const std::vector<Seam>&, const Sewing&,
                                            const Store<double>&);
template void update_closing_times(const std::vector<Seam>&, const Store<float>&, bool, Sewing&);
template void update_closing_times(const std::vector<Seam>&, const Store<double>&, bool, Sewing&);

}  // namespace weft
