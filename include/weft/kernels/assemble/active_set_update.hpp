#pragma once

#include <cmath>
#include <cstdint>

#include "weft/kernels/assemble/contacts.hpp"

namespace weft {

/// Compares what every contact was taken for in a linear solve with what is right where the solve
/// ended - it may pull, and its friction may not be what the normal force allows - and takes it for
/// that from now on. Errors of friction that add up over a component of cloth accelerate it, and so
/// does the pull of contacts that it leaves, while its mesh absorbs errors that cancel. So the sum
/// over each component is compared as well. Contacts that are crushed in a jam become firm, see
/// make_firm(): loads arrive there within a step, so that what a contact remembers does not help.
/// Reads: positions, contacts, touched. Writes: contacts as they push and drag, both sums.
/// Order: mismatch_sq in the contacts' order, in double; force_sum in fixed point, in any order;
/// every rank computes all, or its share of a list that it shares. Ghosts: all vertices.
/// Flags: none.
template <class T>
struct AssembleActiveSetUpdate {
  Span<Contact<T>> contacts;                  ///< of the step, in global order
  Span<const Vec3<T>> positions;              ///< [m] where the solve ended
  Span<const Vec3<T>> positions_t0;           ///< [m] at the start of the step
  Span<const Index> component_of_vertex;      ///< [cloth vertices]
  Span<const double> component_inverse_mass;  ///< [components] [1/kg]
  Index cloth_vertex_count = 0;
  T h;                         ///< [s] effective time step
  double inverse_gravity = 0;  ///< [s^2/m] 0 if nothing has a weight
  /// [>= cloth vertices] see state/touched.hpp; empty: nothing becomes firm
  Span<const unsigned char> touched;
  /// No other solve follows: friction is to stop motion, but not to turn it round, and nothing
  /// becomes firm.
  bool last = false;
  /// The solve has paused early: it shows which contacts push, but not what friction is, nor which
  /// are crushed.
  bool early = false;
  bool compare = false;  ///< contacts stay what they were taken for
  /// Contacts that have met stay what they were taken for: the solve did not know of them, and how
  /// deep it has let them go says nothing of what they bear.
  bool parted = false;
  Span<double> mismatch_sq;  ///< [1] [N^2 s^2] of the impulses, over the cloth's corners
  /// [component_sums * components] forces on each component, in weights of the component /
  /// weight_one, see ComponentForces. Is added to.
  Span<std::int64_t> force_sum;
  /// [contacts] [N^2] what each adds to mismatch_sq, before it is multiplied by h^2; empty: not
  /// wanted. On the host only.
  Span<double> mismatch_of_contact{};
};

/// Fixed-point representation of one in AssembleActiveSetUpdate::force_sum. The force of a contact
/// is limited to 1,024 weights, so that sums over millions of contacts do not overflow.
inline constexpr double weight_one = 1073741824;

/// What a contact adds to the sums.
template <class T>
struct ActiveSetChange {
  double mismatch_sq = 0;  ///< [N^2]
  Vec3<T> friction{};  ///< [N] on the first primitive: right friction less what it was taken for
  Vec3<T> pull{};      ///< [N] on the first primitive: minus what the contact pulled
  T push = 0;          ///< [N] on either: what is right
};

/// By how much stiffer a solve makes a contact at most.
inline constexpr double firmer_max = 24;

/// Makes a contact that is crushed in a jam so stiff that what it bears would leave it
/// crushed_reach_share of its reach, with the same force where it starts.
/// @return [N] by how much more it pushes where the solve ended than it was taken to
template <class T>
WEFT_HD T make_firm(const AssembleActiveSetUpdate<T>& a, Contact<T>& c) noexcept {
  const T gap = gap_at(c, a.positions);
  const T gap_t0 = gap_at(c, a.positions_t0);
  if (!is_crushed(c, gap, gap_t0) || !is_jammed(c, a.touched)) return T(0);
  const T most = static_cast<T>(firmer_max);
  const T room = gap_t0 - static_cast<T>(crushed_reach_share) * c.reach;
  const T factor = most * room > gap_t0 - gap ? (gap_t0 - gap) / room : most;
  const T taken = c.push * (c.thickness - gap);
  if (c.thickness > gap_t0) c.thickness = gap_t0 + (c.thickness - gap_t0) / factor;
  c.stiffness *= factor;
  c.push = c.stiffness;
  return repulsion_force(gap, c.thickness, c.stiffness) - taken;
}

/// Sum of the squares of the weights of a contact's corners of cloth.
template <class T>
WEFT_HD double cloth_weights_sq(const AssembleActiveSetUpdate<T>& a, const Contact<T>& c) noexcept {
  double sum = 0;
  for (int j = 0; j < 4; ++j)
    if (c.v[j] < a.cloth_vertex_count) sum += static_cast<double>(c.w[j] * c.w[j]);
  return sum;
}

/// What a contact adds where the solve has paused early; it is then as it pushes.
template <class T>
WEFT_HD ActiveSetChange<T> early_change(const AssembleActiveSetUpdate<T>& a,
                                        Contact<T>& c) noexcept {
  const T gap = gap_at(c, a.positions);
  const T push = repulsion_force(gap, c.thickness, c.stiffness) > T(0) ? c.stiffness : T(0);
  if (push == c.push) return {};
  const double normal = static_cast<double>((push - c.push) * (c.thickness - gap));
  c.push = push;
  return {cloth_weights_sq(a, c) * (normal * normal)};
}

/// What a contact adds; it is then as it pushes and drags.
template <class T>
WEFT_HD ActiveSetChange<T> active_set_change(const AssembleActiveSetUpdate<T>& a,
                                             Contact<T>& c) noexcept {
  if (a.early) return early_change(a, c);
  if (a.parted && !(gap_at(c, a.positions) > T(0))) return {};
  const double firmer = a.last || a.touched.empty() ? 0 : static_cast<double>(make_firm(a, c));
  const ContactMotion<T> m = contact_motion(c, a.positions, a.positions_t0);
  ContactWeights<T> right = contact_weights(c, m);
  const T depth = c.thickness - m.gap;
  const double normal = firmer + (right.push - c.push) * depth;
  const Vec3<T> friction = friction_force({c.drag, c.drag_limit, c.slide}, m.displacement) -
                           friction_force(right.drag, m.displacement);
  const double tangential = length(friction);
  const Vec3<T> pull = right.push < c.push ? (-c.push * depth) * c.n : Vec3<T>{};
  const T push = right.push * depth;
  const double weights = cloth_weights_sq(a, c);
  if (a.last) {
    // As a secant the force falls with the displacement, and is gone where that ends. A contact
    // that slides to and fro from solve to solve sticks: the force that holds it is between the
    // two.
    const bool turned = dot(c.slide, right.drag.slide) < T(0);
    right.drag = {turned ? c.hold : right.drag.stiffness, T(0), Vec3<T>{}};
  }
  c.push = right.push;
  c.drag = right.drag.stiffness;
  c.drag_limit = right.drag.limit;
  c.slide = right.drag.slide;
  return {weights * (normal * normal + tangential * tangential), friction, pull, push};
}

/// Contact i.
template <class T>
WEFT_HD ActiveSetChange<T> assemble_active_set_update(const AssembleActiveSetUpdate<T>& a,
                                                      Index i) noexcept {
  Contact<T>& c = a.contacts[static_cast<std::size_t>(i)];
  if (!a.compare) return active_set_change(a, c);
  Contact<T> compared = c;
  return active_set_change(a, compared);
}

/// Sums of AssembleActiveSetUpdate::force_sum for each component.
inline constexpr int component_sums = 7;

/// Forces on a component of cloth, as in AssembleActiveSetUpdate::force_sum.
struct ComponentForces {
  Index component = -1;  ///< -1: none
  /// ActiveSetChange::friction and pull, a sum per axis, and push
  std::int64_t sum[component_sums] = {};
};

/// What contact i does to one of its sides. What a component does to itself leaves it where it is.
/// @param side 0: the first primitive
template <class T>
WEFT_HD ComponentForces component_forces(const AssembleActiveSetUpdate<T>& a, Index i, int side,
                                         const ActiveSetChange<T>& change) noexcept {
  using std::rint;
  constexpr double most = 1024;
  const Contact<T>& c = a.contacts[static_cast<std::size_t>(i)];
  Index component[2];
  for (int k = 0; k < 2; ++k) {
    const Index v = c.v[3 * k];
    component[k] =
        v < a.cloth_vertex_count ? a.component_of_vertex[static_cast<std::size_t>(v)] : Index{-1};
  }
  ComponentForces result;
  if (component[side] < 0 || component[0] == component[1]) return result;
  result.component = component[side];
  const double per_force =
      a.inverse_gravity * a.component_inverse_mass[static_cast<std::size_t>(result.component)];
  const T sign = side == 0 ? T(1) : T(-1);
  for (int k = 0; k < component_sums; ++k) {
    const T force = k < 3   ? sign * change.friction[k]
                    : k < 6 ? sign * change.pull[k - 3]
                            : change.push;
    const double weights = static_cast<double>(force) * per_force;
    const double kept = !(weights > -most) ? -most : weights < most ? weights : most;
    result.sum[k] = static_cast<std::int64_t>(rint(kept * weight_one));
  }
  return result;
}

template <class T>
void run(OnHost, Queue& queue, const AssembleActiveSetUpdate<T>& args);
template <class T>
void run(OnCuda, Queue& queue, const AssembleActiveSetUpdate<T>& args);

}  // namespace weft
