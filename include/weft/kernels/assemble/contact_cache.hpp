#pragma once

#include "weft/exec/element_wise.hpp"
#include "weft/kernels/assemble/contacts.hpp"

namespace weft {

/// What each contact leaves to the next step, now that this one is over. Reads: contacts,
/// positions. Writes: memory of its own contact. Order: independent; every rank computes all.
/// Ghosts: all vertices. Flags: none.
template <class T>
struct AssembleContactCache {
  Span<const Contact<T>> contacts;   ///< all of the step, in global order
  Span<const Vec3<T>> positions;     ///< [m] end of the step
  Span<const Vec3<T>> positions_t0;  ///< [m] its start
  T load_share;  ///< of the way from its mean normal force to that of this step, 0 to 1
  Span<ContactMemory<T>> memory;  ///< [contacts]

  WEFT_HD Index count() const noexcept { return static_cast<Index>(contacts.size()); }

  WEFT_HD void operator()(Index i) const noexcept {
    const auto n = static_cast<std::size_t>(i);
    const Contact<T>& c = contacts[n];
    const ContactMotion<T> m = contact_motion(c, positions, positions_t0);
    const T normal_force = repulsion_force(m.gap, c.thickness, c.stiffness);
    const Vec3<T> anchor = anchor_after(m.displacement, c.stiffness, c.friction * normal_force);
    memory[n] = {c.pair,
                 normal_force,
                 c.load + load_share * (normal_force - c.load),
                 c.stiffness * length(m.displacement),
                 c.stiffness * anchor,
                 c.n};
  }
};

}  // namespace weft
