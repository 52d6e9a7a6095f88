#pragma once

#include <cmath>
#include <typeinfo>
#include <vector>

#include "benchmarks/support/grid_system.hpp"
#include "host/exec/for_each.hpp"
#include "weft/exec/launch_observer.hpp"
#include "weft/kernels/assemble/bending.hpp"
#include "weft/kernels/assemble/contacts.hpp"
#include "weft/kernels/assemble/membrane.hpp"
#include "weft/kernels/assemble/rows.hpp"
#if defined(__CUDACC__)
#include "cuda/exec/launch.cuh"
#endif

/// The elements of an assembled system, one by one, as ways of working use them that the engine
/// does not take. Bodies are for both backends: files that launch them are compiled as CUDA where
/// there is a device, and as C++ where there is none.
namespace weft::bench {

/// Submits `body(args, i)` for i = 0 to count - 1; see launch_for_each().
template <class Args, class Body>
void for_each(Queue& queue, const Args& args, Index count, Body body) {
#if defined(__CUDACC__)
  if (queue.backend() == Backend::cuda) {
    launch_for_each(queue, args, count, body);
    return;
  }
#endif
  submit_for_each(queue, args, count, body);
}

/// Adds to a number that other items add to at the same time.
/// @return what it was before
template <class T>
WEFT_HD T add_to(T& number, T value) noexcept {
#if defined(__CUDA_ARCH__)
  return atomicAdd(&number, value);
#else
  const T before = number;
  number += value;
  return before;
#endif
}

/// Raises a number that other items raise at the same time.
WEFT_HD inline void raise_to(Index& number, Index value) noexcept {
#if defined(__CUDA_ARCH__)
  if (number < value) atomicMax(&number, value);
#else
  if (number < value) number = value;
#endif
}

/// What the engine's kernels were launched with to assemble a system of membrane, hinges and
/// contacts on a single rank.
template <class T>
struct SystemArgs {
  AssembleMembrane<T> membrane;
  AssembleBending<T> bending;
  AssembleRows<T> rows;
  AssembleContacts<T> contacts;  ///< row_count 0: there are none
};

/// Catches them.
template <class T>
class CatchSystem final : public LaunchObserver {
 public:
  void before(Queue&) override {}
  void after(Queue&, const std::type_info& kernel, const void* args) override {
    take(kernel, args, system.membrane);
    take(kernel, args, system.bending);
    take(kernel, args, system.rows);
    take(kernel, args, system.contacts);
  }

  SystemArgs<T> system{};

 private:
  template <class Args>
  static void take(const std::type_info& kernel, const void* args, Args& into) {
    if (kernel == typeid(Args)) into = *static_cast<const Args*>(args);
  }
};

/// Assembles, and tells with what. Waits for the device.
template <class T>
SystemArgs<T> assemble_and_catch(FirstSystem<T>& first) {
  CatchSystem<T> caught;
  LaunchObserver::current = &caught;
  first.assemble();
  LaunchObserver::current = nullptr;
  first.sync();
  return caught.system;
}

/// The engine's own assembly once more, without preconditioner and initial guess.
template <class T>
void assemble_again(Queue& queue, const SystemArgs<T>& system) {
  launch_unobserved(queue, system.membrane);
  launch_unobserved(queue, system.bending);
  launch_unobserved(queue, system.rows);
  if (system.contacts.row_count == 0) return;
  queue.copy(system.contacts.rhs.data(), system.rows.rhs.data(),
             system.rows.rhs.size() * sizeof(Vec3<T>));
  launch_unobserved(queue, system.contacts);
}

enum class ElementKind { triangle, hinge, contact, vertex };

/// Corners of an element; -1 where there are fewer, or one is none of the cloth's.
struct Corners {
  Index v[4] = {-1, -1, -1, -1};

  WEFT_HD Index count() const noexcept {
    Index count = 0;
    for (int j = 0; j < 4; ++j) count += v[j] >= 0 ? 1 : 0;
    return count;
  }
};

/// The elements of a system, kind by kind: triangles, hinges, contacts and springs, and vertices,
/// whose masses are elements too. Loops over corners have constant bounds, so that what they index
/// can be kept in registers.
template <class T>
class Elements {
 public:
  WEFT_HD explicit Elements(const SystemArgs<T>& system) noexcept : s_(system) {}

  WEFT_HD Index count(ElementKind kind) const noexcept {
    if (kind == ElementKind::triangle) return size(s_.membrane.triangles);
    if (kind == ElementKind::hinge) return size(s_.bending.hinges);
    if (kind == ElementKind::vertex) return s_.rows.matrix.row_count;
    return s_.contacts.row_count == 0 ? 0 : size(s_.contacts.contacts) + size(s_.contacts.springs);
  }

  template <ElementKind kind>
  WEFT_HD Corners corners(Index n) const noexcept {
    Corners e;
    if constexpr (kind == ElementKind::triangle)
      for (int j = 0; j < 3; ++j) e.v[j] = s_.membrane.triangles.data()[n].v[j];
    if constexpr (kind == ElementKind::hinge)
      for (int j = 0; j < 4; ++j) e.v[j] = s_.bending.hinges.data()[n].v[j];
    if constexpr (kind == ElementKind::contact) {
      const ContactItem<T> item = contact_item(s_.contacts, static_cast<std::size_t>(n));
      for (int j = 0; j < 4; ++j)
        if (j < item.corners && item.v[j] < s_.rows.matrix.row_count) e.v[j] = item.v[j];
    }
    if constexpr (kind == ElementKind::vertex) e.v[0] = n;
    return e;
  }

  /// Calls block(i, j, B) for each pair of corners with what the element adds to that entry, and
  /// impulse(i, p) for each corner. For an iterate without velocity.
  template <ElementKind kind, class Block, class Impulse>
  WEFT_HD void visit(Index number, const Block& block, const Impulse& impulse) const noexcept {
    const auto n = static_cast<std::size_t>(number);
    if constexpr (kind == ElementKind::triangle) visit_triangle(n, block, impulse);
    if constexpr (kind == ElementKind::hinge) visit_hinge(n, block, impulse);
    if constexpr (kind == ElementKind::contact) visit_contact(n, block, impulse);
    if constexpr (kind == ElementKind::vertex) visit_vertex(n, block, impulse);
  }

 private:
  template <class V>
  WEFT_HD static Index size(const Span<V>& span) noexcept {
    return static_cast<Index>(span.size());
  }

  // Triangles and hinges go through the engine's own functions, with room of their own to write to.
  template <class Block, class Impulse>
  WEFT_HD void visit_triangle(std::size_t n, const Block& block,
                              const Impulse& impulse) const noexcept {
    Vec3<T> impulses[3];
    Mat3<T> blocks[6];
    AssembleMembrane<T> one = s_.membrane;
    one.triangles = one.triangles.subspan(n, 1);
    one.inv_rest = one.inv_rest.subspan(n, 1);
    one.area = one.area.subspan(n, 1);
    one.material = one.material.subspan(n, 1);
    if (!one.compression.empty()) one.compression = one.compression.subspan(n, 1);
    one.impulse = {impulses, 3};
    one.block = {blocks, 6};
    assemble_membrane(one, 0);
    AssembleRows<T> rows{};
    rows.triangle_block = one.block;
    for (int i = 0; i < 3; ++i) {
      impulse(i, impulses[i]);
      for (int j = 0; j < 3; ++j) block(i, j, rows.element_block(3 * i + j));
    }
  }
  template <class Block, class Impulse>
  WEFT_HD void visit_hinge(std::size_t n, const Block& block,
                           const Impulse& impulse) const noexcept {
    Vec3<T> direction[4];
    T scale{}, curvature{};
    AssembleBending<T> one = s_.bending;
    one.hinges = one.hinges.subspan(n, 1);
    one.stiffness = one.stiffness.subspan(n, 1);
    one.rest_angle = one.rest_angle.subspan(n, 1);
    one.damping = one.damping.subspan(n, 1);
    one.direction = {direction, 4};
    one.impulse_scale = {&scale, 1};
    one.curvature = {&curvature, 1};
    one(0);
    for (int i = 0; i < 4; ++i) {
      impulse(i, scale * direction[i]);
      for (int j = 0; j < 4; ++j) block(i, j, outer(curvature * direction[i], direction[j]));
    }
  }
  template <class Block, class Impulse>
  WEFT_HD void visit_contact(std::size_t n, const Block& block,
                             const Impulse& impulse) const noexcept {
    const ContactItem<T> item = contact_item(s_.contacts, n);
    const ContactTerms<T> terms = item_terms(s_.contacts, n);
    for (int i = 0; i < 4; ++i) {
      if (i >= item.corners) continue;
      impulse(i, item.w[i] * terms.impulse);
      for (int j = 0; j < 4; ++j)
        if (j < item.corners) block(i, j, (item.w[i] * item.w[j]) * terms.block);
    }
  }
  template <class Block, class Impulse>
  WEFT_HD void visit_vertex(std::size_t v, const Block& block,
                            const Impulse& impulse) const noexcept {
    const AssembleRows<T>& a = s_.rows;
    const T mass = a.mass.data()[v];
    impulse(0, mass * (a.base_velocities.data()[v] + a.h * a.gravity));
    block(0, 0, (mass * (T(1) + a.h * a.damping_mass.data()[v])) * Mat3<T>::identity());
  }

  const SystemArgs<T>& s_;
};

/// Submits `Body<kind>` for every element of args.system, a launch a kind.
template <template <ElementKind> class Body, class T, template <class> class Args>
void for_each_element(Queue& queue, const Args<T>& args) {
  const Elements<T> elements(args.system);
  const auto submit = [&](ElementKind kind, auto body) {
    if (elements.count(kind) > 0) for_each(queue, args, elements.count(kind), body);
  };
  submit(ElementKind::vertex, Body<ElementKind::vertex>{});
  submit(ElementKind::triangle, Body<ElementKind::triangle>{});
  submit(ElementKind::hinge, Body<ElementKind::hinge>{});
  submit(ElementKind::contact, Body<ElementKind::contact>{});
}

}  // namespace weft::bench
