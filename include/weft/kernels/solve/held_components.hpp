#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/exec/launch.hpp"
#include "weft/state/contact.hpp"

namespace weft {

/// Marks the components of cloth that are in contact with something else, so that they need not
/// fall freely. What a component does to itself leaves it where it is.
/// Reads: contacts. Writes: held. Order: independent, since all write the same number. Ghosts: none
/// (every rank does all contacts). Flags: none.
template <class T>
struct SolveHeldComponents {
  Span<const Contact<T>> contacts;        ///< all of the step
  Span<const Index> component_of_vertex;  ///< [cloth vertices]
  Span<Index> held;                       ///< [components] 1: in contact; is added to
};

template <class T>
WEFT_HD void solve_held_components(const SolveHeldComponents<T>& a, Index i) noexcept {
  const Contact<T>& c = a.contacts[static_cast<std::size_t>(i)];
  Index component[2];
  for (int k = 0; k < 2; ++k) {
    const auto v = static_cast<std::size_t>(c.v[3 * k]);
    component[k] = v < a.component_of_vertex.size() ? a.component_of_vertex[v] : Index{-1};
  }
  if (component[0] == component[1]) return;
  for (const Index held : component)
    if (held >= 0) a.held[static_cast<std::size_t>(held)] = 1;
}

template <class T>
void run(OnHost, Queue& queue, const SolveHeldComponents<T>& args);
template <class T>
void run(OnCuda, Queue& queue, const SolveHeldComponents<T>& args);

}  // namespace weft
