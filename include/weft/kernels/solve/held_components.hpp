#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/exec/element_wise.hpp"
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

  WEFT_HD Index count() const noexcept { return static_cast<Index>(contacts.size()); }

  WEFT_HD void operator()(Index i) const noexcept {
    const Contact<T>& c = contacts[static_cast<std::size_t>(i)];
    Index component[2];
    for (int k = 0; k < 2; ++k) {
      const auto v = static_cast<std::size_t>(c.v[3 * k]);
      component[k] = v < component_of_vertex.size() ? component_of_vertex[v] : Index{-1};
    }
    if (component[0] == component[1]) return;
    for (const Index of : component)
      if (of >= 0) held[static_cast<std::size_t>(of)] = 1;
  }
};

}  // namespace weft
