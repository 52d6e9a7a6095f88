#pragma once

#include "weft/exec/element_wise.hpp"
#include "weft/kernels/assemble/contacts.hpp"

namespace weft {

/// What each contact leaves to the next step, now that this one is over, and the vertices of those
/// that are crushed. Reads: contacts, positions, touched. Writes: memory of its own contact, marks
/// of its vertices, to which all contacts write the same. Order: independent; every rank computes
/// all. Ghosts: all vertices. Flags: none.
template <class T>
struct AssembleContactCache {
  Span<const Contact<T>> contacts;   ///< all of the step, in global order
  Span<const Vec3<T>> positions;     ///< [m] end of the step
  Span<const Vec3<T>> positions_t0;  ///< [m] its start
  T load_share;  ///< of the way from its mean normal force to that of this step, 0 to 1
  Span<ContactMemory<T>> memory;       ///< [contacts]
  Span<const unsigned char> touched;   ///< [cloth vertices] see state/touched.hpp
  Span<unsigned char> crushed;         ///< [cloth vertices] set to 1: a contact is_crushed()
  Span<unsigned char> crushed_in_jam;  ///< [cloth vertices] the same of one that is_jammed()

  WEFT_HD Index count() const noexcept { return static_cast<Index>(contacts.size()); }

  WEFT_HD void operator()(Index i) const noexcept {
    const auto n = static_cast<std::size_t>(i);
    const Contact<T>& c = contacts[n];
    const ContactMotion<T> m = contact_motion(c, positions, positions_t0);
    const T normal_force = repulsion_force(m.gap, c.thickness, c.stiffness);
    const Vec3<T> anchor = anchor_after(m.displacement, c.hold, c.friction * normal_force);
    memory[n] = {c.pair,
                 normal_force,
                 c.load + load_share * (normal_force - c.load),
                 c.hold * length(m.displacement),
                 c.hold * anchor,
                 c.n};
    if (is_crushed(c, m.gap, gap_at(c, positions_t0))) mark(c);
  }

 private:
  WEFT_HD void mark(const Contact<T>& c) const noexcept {
    const bool jammed = is_jammed(c, touched);
    for (const Index v : c.v) {
      crushed[static_cast<std::size_t>(v)] = 1;
      if (jammed) crushed_in_jam[static_cast<std::size_t>(v)] = 1;
    }
  }
};

}  // namespace weft
