#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/elements/contact.hpp"
#include "weft/elements/spring.hpp"
#include "weft/exec/launch.hpp"
#include "weft/state/contact.hpp"
#include "weft/state/contact_operator.hpp"
#include "weft/state/touched.hpp"

namespace weft {

/// Contact part of the system for the rows of one rank: repulsion and friction of every contact
/// that touches them, and the springs of handles and seams, rebuilt each time. Reads: positions of
/// all vertices, cloth at iterate x_k and at the step's start, obstacle at its end and start.
/// Writes: links, rhs (adds). Order: contacts in their global order, then springs; a row has its
/// ends in that order, so that its sum is the same for every partition; on CUDA a row's impulses
/// are added up by a fixed number of threads. Ghosts: all vertices. Flags: none.
template <class T>
struct AssembleContacts {
  Index row_begin = 0;
  Index row_count = 0;
  Index cloth_vertex_count = 0;
  Span<const Contact<T>> contacts;   ///< all of the step, in global order
  Span<const Spring<T>> springs;     ///< as above
  Span<const Vec3<T>> positions;     ///< [m] cloth x_k, obstacle at the end of the step
  Span<const Vec3<T>> positions_t0;  ///< [m] at the start of the step
  T h;                               ///< [s] effective time step
  bool as_taken = true;  ///< contacts push and drag as they say, not as the iterate does
  /// [rows + 1] out: where each row's part of contact_scatter begins
  Span<Index> row_entry_count;
  /// [4 contacts + 2 springs] scratch: 4 n + corner of contact n, of spring n - contacts
  Span<Index> row_entry;
  Span<Vec3<T>> rhs;  ///< [rows] [N s]
  // See ContactOperator
  Span<ContactOperatorEntry<T>> link;       ///< [contacts + springs]
  Span<Index> contact_entry_count;          ///< [1] links that there are
  Span<ContactScatter<T>> contact_scatter;  ///< [4 contacts + 2 springs]
};

/// How a contact stands at some positions.
template <class T>
struct ContactMotion {
  T gap;                 ///< [m]
  Vec3<T> displacement;  ///< [m] tangential, with the anchor
};

template <class T>
WEFT_HD ContactMotion<T> contact_motion(const Contact<T>& c, const Span<const Vec3<T>>& positions,
                                        const Span<const Vec3<T>>& positions_t0) noexcept {
  Vec3<T> x[4];
  Vec3<T> slip{};
  for (int j = 0; j < 4; ++j) {
    const auto v = static_cast<std::size_t>(c.v[j]);
    x[j] = positions[v];
    slip += c.w[j] * (x[j] - positions_t0[v]);
  }
  return {contact_gap(c.n, x, c.w), c.anchor + tangential(slip, c.n)};
}

/// Share of Contact::reach to which a crushed contact closes, see is_crushed().
inline constexpr double crushed_reach_share = 0.8;

/// Whether a contact gives way to something far stronger than what it was made for: it closes in
/// the step to less than that share of its reach, although it bears more than its yield.
/// @param gap, gap_t0 [m] at the end of the step and at its start
template <class T>
WEFT_HD bool is_crushed(const Contact<T>& c, T gap, T gap_t0) noexcept {
  return gap < static_cast<T>(crushed_reach_share) * c.reach && gap < T(0.999) * gap_t0 &&
         repulsion_force(gap, c.thickness, c.stiffness) > c.yield;
}

/// [m] gap of a contact
template <class T>
WEFT_HD T gap_at(const Contact<T>& c, const Span<const Vec3<T>>& positions) noexcept {
  Vec3<T> x[4];
  for (int j = 0; j < 4; ++j) x[j] = positions[static_cast<std::size_t>(c.v[j])];
  return contact_gap(c.n, x, c.w);
}

/// Whether a vertex of a contact within a cloth has a level.
/// @param touched [cloth vertices] see state/touched.hpp
template <class T>
WEFT_HD bool is_jammed(const Contact<T>& c, const Span<const unsigned char>& touched) noexcept {
  for (const Index v : c.v)
    if (touched_level(touched[static_cast<std::size_t>(v)]) > 0) return true;
  return false;
}

/// What a contact amounts to in a linear system.
template <class T>
struct ContactWeights {
  T push;                   ///< [N/m] along the normal
  FrictionTangent<T> drag;  ///< across it
};

/// The weights that are right at a motion: pushing but not pulling, and sticking up to the limit.
template <class T>
WEFT_HD ContactWeights<T> contact_weights(const Contact<T>& c, const ContactMotion<T>& m) noexcept {
  const T normal_force = repulsion_force(m.gap, c.thickness, c.stiffness);
  if (!(normal_force > T(0))) return {};
  const T limit = c.friction * normal_force;
  // Without friction nothing sticks, where nothing has moved yet either.
  if (!(limit > T(0))) return {c.stiffness, FrictionTangent<T>{}};
  return {c.stiffness, friction_tangent(c.hold, limit, m.displacement)};
}

/// One contact against the iterate: its impulse h f and the matrix h^2 K that all its corners share
/// up to their weights.
template <class T>
struct ContactTerms {
  Vec3<T> impulse;  ///< [N s] corner j receives w[j] times this
  Mat3<T> block;    ///< [kg] corners i, j receive w[i] w[j] times this
};

template <class T>
WEFT_HD ContactTerms<T> contact_terms(const AssembleContacts<T>& a, const Contact<T>& c) noexcept {
  const ContactMotion<T> m = contact_motion(c, a.positions, a.positions_t0);
  const ContactWeights<T> k = a.as_taken
                                  ? ContactWeights<T>{c.push, {c.drag, c.drag_limit, c.slide}}
                                  : contact_weights(c, m);
  ContactTerms<T> terms;
  terms.impulse =
      a.h * (k.push * (c.thickness - m.gap) * c.n - friction_force(k.drag, m.displacement));
  const Mat3<T> nn = outer(c.n, c.n);
  terms.block = (a.h * a.h) *
                (k.push * nn +
                 k.drag.stiffness * (Mat3<T>::identity() - nn - outer(k.drag.slide, k.drag.slide)));
  return terms;
}

/// The same for a spring, whose corners have the weights 1 and -1.
template <class T>
WEFT_HD ContactTerms<T> spring_terms(const AssembleContacts<T>& a, const Spring<T>& s) noexcept {
  const Vec3<T> from = s.v[1] < 0 ? s.anchor : a.positions[static_cast<std::size_t>(s.v[1])];
  const Vec3<T> d = spring_span(a.positions[static_cast<std::size_t>(s.v[0])] - from, s.along);
  ContactTerms<T> terms{a.h * spring_force(d, s.rest, s.stiffness),
                        (a.h * a.h) * spring_stiffness(d, s.rest, s.stiffness, s.along)};
  if (!(s.drag > T(0))) return terms;
  const Vec3<T> d_t0 = a.positions_t0[static_cast<std::size_t>(s.v[0])] -
                       a.positions_t0[static_cast<std::size_t>(s.v[1])];
  const Mat3<T> drag = spring_drag(d_t0, s.rest, s.drag);
  terms.impulse -= a.h * (drag * (d - d_t0));
  terms.block += (a.h * a.h) * drag;
  return terms;
}

/// A contact or a spring as the rows see it.
template <class T>
struct ContactItem {
  int corners = 0;
  Index v[4];
  T w[4];
};

/// Number n of all contacts and, behind them, all springs.
template <class T>
WEFT_HD ContactItem<T> contact_item(const AssembleContacts<T>& a, std::size_t n) noexcept {
  if (n < a.contacts.size()) {
    const Contact<T>& c = a.contacts[n];
    return {4, {c.v[0], c.v[1], c.v[2], c.v[3]}, {c.w[0], c.w[1], c.w[2], c.w[3]}};
  }
  const Spring<T>& s = a.springs[n - a.contacts.size()];
  return {s.v[1] < 0 ? 1 : 2, {s.v[0], s.v[1]}, {T(1), T(-1)}};
}

template <class T>
WEFT_HD ContactTerms<T> item_terms(const AssembleContacts<T>& a, std::size_t n) noexcept {
  return n < a.contacts.size() ? contact_terms(a, a.contacts[n])
                               : spring_terms(a, a.springs[n - a.contacts.size()]);
}

/// An item in products, see ContactOperatorEntry.
template <class T>
WEFT_HD ContactOperatorEntry<T> contact_operator_entry(const ContactItem<T>& item,
                                                       const Mat3<T>& block,
                                                       Index cloth_vertex_count) noexcept {
  ContactOperatorEntry<T> link{};
  Index some = 0;
  for (int j = 0; j < item.corners; ++j)
    if (item.v[j] < cloth_vertex_count) some = item.v[j];
  for (int j = 0; j < 4; ++j) {
    const bool real = j < item.corners && item.v[j] < cloth_vertex_count;
    link.v[j] = real ? item.v[j] : some;
    link.w[j] = real ? item.w[j] : T(0);
  }
  const T upper[6] = {block(0, 0), block(0, 1), block(0, 2), block(1, 1), block(1, 2), block(2, 2)};
  for (int k = 0; k < 6; ++k) link.block[k] = upper[k];
  return link;
}

template <class T>
void run(OnHost, Queue& queue, const AssembleContacts<T>& args);
template <class T>
void run(OnCuda, Queue& queue, const AssembleContacts<T>& args);

}  // namespace weft
