#include "host/implicit/linear/held_components.hpp"

#include <algorithm>
#include <utility>

#include "host/implicit/linear/element_buffers.hpp"
#include "host/implicit/linear/rank_rows.hpp"
#include "host/model/model_part.hpp"
#include "weft/kernels/solve/held_components.hpp"

namespace weft {

template <class T>
HeldComponents<T>::HeldComponents(Store<T>& store)
    : store_(store),
      can_fall_(!blows(store.scene().wind) && store.model().pressure.empty()),
      component_of_vertex_(cloth_components(store.model())) {
  Index last = -1;
  for (const Index c : component_of_vertex_) last = std::max(last, c);
  pinned_.resize(static_cast<std::size_t>(last + 1));
  note_pins(fixed_vertices(store.scene(), store.model(), store.time));
}

template <class T>
void HeldComponents<T>::make_ranks() {
  const MemoryName name("solver");
  ranks_.clear();
  for (int r = 0; r < store_.devices().size(); ++r) {
    ranks_.emplace_back();
    make(store_.devices()[r], ranks_.back().always, 0);
    make(store_.devices()[r], ranks_.back().held, 0);
  }
}

template <class T>
void HeldComponents<T>::note_pins(const std::vector<unsigned char>& fixed) {
  std::fill(pinned_.begin(), pinned_.end(), 0);
  for (std::size_t v = 0; v < component_of_vertex_.size(); ++v)
    if (fixed[v] != 0) pinned_[static_cast<std::size_t>(component_of_vertex_[v])] = 1;
}

template <class T>
void HeldComponents<T>::set_springs(const std::vector<Spring<T>>& springs) {
  const auto component = [this](Index v) {
    return component_of_vertex_[static_cast<std::size_t>(v)];
  };
  std::vector<Index> held = pinned_;
  for (const Spring<T>& s : springs) {
    if (s.v[1] >= 0 && component(s.v[0]) == component(s.v[1])) continue;
    for (const Index v : s.v)
      if (v >= 0) held[static_cast<std::size_t>(component(v))] = 1;
  }
  for (int r = 0; r < store_.devices().size(); ++r) {
    Buffer<Index>& always = ranks_[static_cast<std::size_t>(r)].always;
    if (held != always_ || always.size() == 0) upload(store_.devices()[r].compute(), always, held);
  }
  always_ = std::move(held);
}

template <class T>
bool HeldComponents<T>::all_fall() const {
  return can_fall() && !always_.empty() &&
         std::all_of(always_.begin(), always_.end(), [](Index held) { return held == 0; });
}

template <class T>
Span<const Index> HeldComponents<T>::mark(int r, const RankGeometry<T>& geometry,
                                          Span<const Contact<T>> contacts) {
  Rank& rank = ranks_[static_cast<std::size_t>(r)];
  Queue& queue = store_.devices()[r].compute();
  rank.held.resize(rank.always.size());
  queue.copy(rank.held.data(), rank.always.data(), rank.held.size() * sizeof(Index));
  if (!contacts.empty())
    launch(queue,
           SolveHeldComponents<T>{contacts, geometry.component_of_vertex.span(), rank.held.span()});
  return rank.held.span();
}

template class HeldComponents<float>;
template class HeldComponents<double>;

}  // namespace weft
