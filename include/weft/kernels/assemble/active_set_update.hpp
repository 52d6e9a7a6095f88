#pragma once

#include "weft/kernels/assemble/contacts.hpp"

namespace weft {

/// Compares what every contact was taken for in a linear solve with what is right where the solve
/// ended - it may pull, and its friction may not be what the normal force allows - and takes it for
/// that from now on. Reads: positions, contacts. Writes: push and drag of contacts, mismatch_sq.
/// Order: the sum in the contacts' order, in double; every rank computes all. Ghosts: all vertices.
/// Flags: none.
template <class T>
struct AssembleActiveSetUpdate {
  Span<Contact<T>> contacts;         ///< all of the step, in global order
  Span<const Vec3<T>> positions;     ///< [m] where the solve ended
  Span<const Vec3<T>> positions_t0;  ///< [m] at the start of the step
  Index cloth_vertex_count = 0;
  T h;                       ///< [s] effective time step
  bool last = false;         ///< friction is to stop motion, but not to turn it round
  Span<double> mismatch_sq;  ///< [1] [N^2 s^2] of the impulses, over the cloth's corners
};

/// Contact i; what it adds to the sum, before h^2.
template <class T>
WEFT_HD double assemble_active_set_update(const AssembleActiveSetUpdate<T>& a, Index i) noexcept {
  Contact<T>& c = a.contacts[static_cast<std::size_t>(i)];
  const ContactMotion<T> m = contact_motion(c, a.positions, a.positions_t0);
  ContactWeights<T> right = contact_weights(c, m);
  const double normal = (right.push - c.push) * (c.thickness - m.gap);
  const double tangential = length(friction_force(right.drag, m.displacement) -
                                   friction_force({c.drag, c.drag_limit, c.slide}, m.displacement));
  double weights = 0;
  for (int j = 0; j < 4; ++j)
    if (c.v[j] < a.cloth_vertex_count) weights += static_cast<double>(c.w[j] * c.w[j]);
  // As a secant the force falls with the displacement, and is gone where that ends.
  if (a.last) right.drag = {right.drag.stiffness, T(0), Vec3<T>{}};
  c.push = right.push;
  c.drag = right.drag.stiffness;
  c.drag_limit = right.drag.limit;
  c.slide = right.drag.slide;
  return weights * (normal * normal + tangential * tangential);
}

template <class T>
void run(OnHost, Queue& queue, const AssembleActiveSetUpdate<T>& args);
template <class T>
void run(OnCuda, Queue& queue, const AssembleActiveSetUpdate<T>& args);

}  // namespace weft
