#pragma once

#include "weft/kernels/assemble/contacts.hpp"

namespace weft {

/// Compares what every contact was taken for in a linear solve with what is right where the solve
/// ended - it may pull, and its friction may not be what the normal force allows - and takes it for
/// that from now on. Reads: positions, contacts. Writes: push and drag of contacts, mismatch_sq.
/// Order: the sum in the contacts' order, in double; every rank computes all. Ghosts: all vertices.
/// Flags: none.
template <class T>
struct AssembleReweigh {
  Span<Contact<T>> contacts;         ///< all of the step, in global order
  Span<const Vec3<T>> positions;     ///< [m] where the solve ended
  Span<const Vec3<T>> positions_t0;  ///< [m] at the start of the step
  Index cloth_vertex_count = 0;
  T h;                       ///< [s] effective time step
  bool last = false;         ///< friction is to stop motion, but not to turn it round
  Span<double> mismatch_sq;  ///< [1] [N^2 s^2] of the impulses, over the cloth's corners
};

template <class T>
void run(OnHost, Queue& queue, const AssembleReweigh<T>& args);

}  // namespace weft
