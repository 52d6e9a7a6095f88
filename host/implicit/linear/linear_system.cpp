#include "host/implicit/linear/linear_system.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <utility>

#include "host/implicit/parallel/exchange.hpp"
#include "host/model/material_rows.hpp"
#include "host/model/model_part.hpp"
#include "weft/kernels/assemble/bending.hpp"
#include "weft/kernels/assemble/contacts.hpp"
#include "weft/kernels/assemble/pressure.hpp"
#include "weft/kernels/assemble/rows.hpp"
#include "weft/kernels/assemble/step_energy.hpp"
#include "weft/kernels/assemble/wind.hpp"
#include "weft/kernels/integrate/update.hpp"
#include "weft/kernels/solve/halo.hpp"
#include "weft/kernels/solve/held_components.hpp"
#include "weft/kernels/solve/initial_guess.hpp"
#include "weft/kernels/solve/precondition.hpp"
#include "weft/kernels/solve/products.hpp"
#include "weft/kernels/solve/schwarz_level.hpp"

namespace weft {
namespace {

/// The items of `all` that `chosen` names.
template <class T>
std::vector<T> pick(const std::vector<T>& all, const std::vector<Index>& chosen) {
  std::vector<T> out;
  out.reserve(chosen.size());
  for (const Index i : chosen) out.push_back(all[static_cast<std::size_t>(i)]);
  return out;
}

/// By how much of the contacts' thickness a solve may leave vertices away from where they belong,
/// root mean square over the cloth's mass. Where contacts press hard a share of the first residual
/// is more than that. Nor may velocities of several components of cloth be off by more than
/// `solver.tolerance` of what gravity adds in the step: where one is pulled fast from under
/// another, a share of what the pull leaves to solve for is more than all friction on the other.
/// While springs pull, what they leave is worth no such effort.
constexpr double misplaced_share = 0.05;

bool blows(const Wind& wind) {
  return wind.density > 0 || wind.drag > 0;
}

}  // namespace

template <class T>
LinearSystem<T>::LinearSystem(Store<T>& store, std::vector<RankGeometry<T>>& geometry,
                              std::vector<RankMotion<T>>& motion)
    : store_(store), geometry_(geometry), motion_(motion), ranks_(geometry.size()) {
  const std::vector<unsigned char> fixed = fixed_vertices(store.scene(), store.model(), store.time);
  plate_ = store.plate(fixed);
  component_of_vertex_ = cloth_components(store.model());
  note_pins(fixed);
  can_fall_ = !blows(store.scene().wind) && store.model().pressure.empty();
  make_ranks();
  weight_ = store.model().whole.mass_2_norm * length(store.scene().gravity);
}

template <class T>
void LinearSystem<T>::make_elements(int r, const MeshRows& rows) {
  const Model& m = store_.model();
  Device& device = store_.devices()[r];
  Rank& rank = ranks_[static_cast<std::size_t>(r)];
  MemoryName name("elements");
  const auto put = [&](auto& buffer, const auto& values) {
    buffer = std::remove_reference_t<decltype(buffer)>(device);
    upload(device.compute(), buffer, values);
  };
  put(rank.triangles, pick(m.triangles, rows.triangles));
  put(rank.inv_rest, cast_all<T>(pick(m.inv_rest, rows.triangles)));
  put(rank.area, cast_all<T>(pick(m.area, rows.triangles)));
  put(rank.pressure,
      m.pressure.empty() ? std::vector<T>{} : cast_all<T>(pick(m.pressure, rows.triangles)));
  rank.numbers = rows.triangles;
  rank.compression = Buffer<T>(device);
  put(rank.material, pick(m.material, rows.triangles));
  const MaterialRows<T>& materials = m.laws->template in<T>();
  put(rank.materials, materials.rows);
  put(rank.material_tables, materials.tables);
  put(rank.hinges, pick(m.hinges, rows.hinges));
  put(rank.hinge_stiffness, cast_all<T>(pick(m.hinge_stiffness, rows.hinges)));
  put(rank.hinge_rest_angle, cast_all<T>(pick(m.hinge_rest_angle, rows.hinges)));
  put(rank.hinge_damping, cast_all<T>(pick(m.hinge_damping, rows.hinges)));
  name.change("matrix");
  put(rank.slice_offset, rows.slice_offset);
  put(rank.column, rows.column);
  put(rank.block_source_offset, rows.block_source_offset);
  put(rank.block_source, rows.block_source);
  put(rank.corner_source_offset, rows.corner_source_offset);
  put(rank.corner_source, rows.corner_source);
}

/// Brings the ranks up to what the store's model says of compression.
template <class T>
void LinearSystem<T>::take_compression() {
  if (compression_epoch_ == store_.compression_epoch()) return;
  compression_epoch_ = store_.compression_epoch();
  const std::vector<double>& all = store_.model().compression;
  for (int r = 0; r < store_.devices().size(); ++r) {
    Rank& rank = ranks_[static_cast<std::size_t>(r)];
    upload(store_.devices()[r].compute(), rank.compression,
           all.empty() ? std::vector<T>{} : cast_all<T>(pick(all, rank.numbers)));
  }
}

template <class T>
Index LinearSystem<T>::partial_rows() const {
  const bool plain = store_.scene().solver.preconditioner == Preconditioner::block_jacobi;
  return std::min(store_.partition().partial_rows,
                  plain ? pcg_plain_partial_rows_max : pcg_partial_rows_max);
}

template <class T>
void LinearSystem<T>::make_rank(int r) {
  const MeshRows rows = make_mesh_rows(store_.model(), store_.partition(), r);
  make_elements(r, rows);
  make_plate_part(r, rows);
  MemoryName name("elements");
  Device& device = store_.devices()[r];
  Rank& rank = ranks_[static_cast<std::size_t>(r)];
  const auto make = [&](auto& buffer, std::size_t size) {
    buffer = std::remove_reference_t<decltype(buffer)>(device, size);
  };
  const auto own = static_cast<std::size_t>(row_count(r));
  const auto cloth = static_cast<std::size_t>(store_.model().cloth_vertex_count);
  const auto all = static_cast<std::size_t>(store_.model().vertex_count);
  make(rank.triangle_impulse, 3 * rows.triangles.size());
  make(rank.triangle_block, 6 * rows.triangles.size());
  make(rank.corner_drag, blows(store_.scene().wind) ? rows.triangles.size() : 0);
  make(rank.hinge_direction, 4 * rows.hinges.size());
  make(rank.hinge_impulse_scale, rows.hinges.size());
  make(rank.hinge_curvature, rows.hinges.size());
  name.change("matrix");
  make(rank.value, 9 * rows.column.size());
  make(rank.diagonal, own);
  make(rank.vertex_mass, own);
  make(rank.vertex_drag, rank.corner_drag.size() > 0 ? own : 0);
  make(rank.springs, 0);
  make(rank.row_entry_count, own + 1);
  make(rank.row_entry, 0);
  const bool linked = device.backend() == Backend::cuda;
  make(rank.contact_offset, linked ? 0 : own + 1);
  make(rank.contact_column, 0);
  make(rank.contact_value, 0);
  make(rank.link, 0);
  make(rank.contact_entry_count, linked ? 1 : 0);
  make(rank.contact_scatter, 0);
  make(rank.contact_gather, 0);
  name.change("solver");
  make(rank.iterate_positions, all);
  make(rank.iterate_velocities, cloth);
  for (auto* buffer : {&rank.mesh_rhs, &rank.rhs, &rank.r, &rank.w, &rank.p, &rank.s})
    make(*buffer, own);
  name.change("preconditioner");
  make(rank.inverse, own);
  make_preconditioner(r);
  name.change("solver");
  make(rank.held_always, 0);
  make(rank.held, 0);
  make(rank.x, cloth);
  make(rank.u, cloth);
  make(rank.stamp, cloth);
  make(rank.ghost, cloth);
  make(rank.ghost_offset, static_cast<std::size_t>(store_.devices().size()) + 1);
  make(rank.partial, 6 * static_cast<std::size_t>(
                             pcg_partials(store_.model().cloth_vertex_count, partial_rows())));
  make(rank.ready, pcg_flags);
  make(rank.receivers, store_.devices().size() > 1 ? own : 0);
  make(rank.status, 1);
  make(rank.parts, ranks_.size());
  device.compute().fill(rank.stamp.data(), 0, cloth * sizeof(Index));
  device.compute().fill(rank.ready.data(), 0, pcg_flags * sizeof(std::uint32_t));
  device.compute().sync();
}

template <class T>
BlockEll<T> LinearSystem<T>::mesh_view(int r) const {
  const Rank& rank = ranks_[static_cast<std::size_t>(r)];
  return {row_count(r),       store_.partition().slice, rank.slice_offset.span(),
          rank.column.span(), rank.value.span(),        rank.diagonal.span()};
}

template <class T>
ContactPart<T> LinearSystem<T>::contact_view(int r) const {
  const Rank& rank = ranks_[static_cast<std::size_t>(r)];
  if (!rank.has_contacts) return {};
  if (store_.devices().backend() == Backend::cuda)
    return {{},
            {rank.link.span(), rank.contact_entry_count.span(), rank.row_entry_count.span(),
             rank.contact_scatter.span(), rank.contact_gather.span()}};
  return {{row_count(r), 1, rank.contact_offset.span(), rank.contact_column.span(),
           rank.contact_value.span()},
          {}};
}

template <class T>
ScalarEll<T> LinearSystem<T>::far_view(int r) const {
  const Rank& rank = ranks_[static_cast<std::size_t>(r)];
  if (rank.off_pattern_column.size() == 0) return {};
  return {row_count(r), store_.partition().slice, rank.off_pattern_slice_offset.span(),
          rank.off_pattern_column.span(), rank.off_pattern_value.span()};
}

template <class T>
Span<const Vec3<T>> LinearSystem<T>::element_positions(int r, const Linearisation& at) const {
  if (at.translated) return store_.rank(r).positions.span();
  return ranks_[static_cast<std::size_t>(r)].iterate_positions.span();
}

template <class T>
Span<const Vec3<T>> LinearSystem<T>::element_rates(int r, const Linearisation& at) const {
  if (at.without_rates) return {};
  return ranks_[static_cast<std::size_t>(r)].iterate_velocities.span();
}

template <class T>
void LinearSystem<T>::assemble_elements(int r, const Linearisation& at) {
  const auto n = static_cast<std::size_t>(r);
  Rank& rank = ranks_[n];
  Queue& queue = store_.devices()[r].compute();
  const Span<const Vec3<T>> positions = element_positions(r, at);
  const Span<const Vec3<T>> rates = element_rates(r, at);
  const Span<const Vec3<T>> velocities = rank.iterate_velocities.span();
  const auto h = static_cast<T>(at.h);
  launch(queue, AssembleMembrane<T>{rank.triangles.span(), rank.inv_rest.span(), rank.area.span(),
                                    rank.material.span(), rank.materials.span(), positions, rates,
                                    h, rank.triangle_impulse.span(), rank.triangle_block.span(),
                                    rank.material_tables.span(), rank.compression.span()});
  if (rank.pressure.size() > 0)
    launch(queue, AssemblePressure<T>{rank.triangles.span(), rank.pressure.span(), positions, h,
                                      rank.triangle_impulse.span()});
  const Wind& wind = store_.scene().wind;
  if (blows(wind))
    launch(queue, AssembleWind<T>{rank.triangles.span(), store_.rank(r).positions.span(),
                                  store_.rank(r).velocities.span(), velocities,
                                  static_cast<T>(wind.density), static_cast<T>(wind.drag),
                                  vec_cast<T>(wind.velocity), h, rank.triangle_impulse.span(),
                                  rank.triangle_block.span(), rank.corner_drag.span()});
  launch(queue, AssembleBending<T>{rank.hinges.span(), rank.hinge_stiffness.span(),
                                   rank.hinge_rest_angle.span(), rank.hinge_damping.span(),
                                   positions, rates, h, rank.hinge_direction.span(),
                                   rank.hinge_impulse_scale.span(), rank.hinge_curvature.span()});
  const Vec3<double>& g = store_.scene().gravity;
  launch(queue, AssembleRows<T>{row_begin(r),
                                {row_count(r), store_.partition().slice, rank.slice_offset.span(),
                                 rank.column.span(), rank.value.span(), rank.diagonal.span()},
                                rank.block_source_offset.span(),
                                rank.block_source.span(),
                                rank.corner_source_offset.span(),
                                rank.corner_source.span(),
                                rank.triangle_block.span(),
                                rank.triangle_impulse.span(),
                                rank.hinge_direction.span(),
                                rank.hinge_impulse_scale.span(),
                                rank.hinge_curvature.span(),
                                geometry_[n].mass.span(),
                                geometry_[n].damping_mass.span(),
                                motion_[n].base_velocities.span(),
                                velocities,
                                vec_cast<T>(g),
                                h,
                                rank.mesh_rhs.span(),
                                rank.vertex_mass.span(),
                                rank.corner_drag.span(),
                                rank.vertex_drag.span()});
  if (rank.in_pattern_offset.size() > 0) assemble_plate(r, at);
}

template <class T>
void LinearSystem<T>::assemble_contact_rows(int r, const Linearisation& at,
                                            Span<const Contact<T>> contacts) {
  const auto n = static_cast<std::size_t>(r);
  Rank& rank = ranks_[n];
  const std::size_t springs = rank.springs.size();
  rank.has_contacts = !contacts.empty() || springs > 0;
  if (!rank.has_contacts) return;
  const bool linked = store_.devices().backend() == Backend::cuda;
  const std::size_t ends = 4 * contacts.size() + 2 * springs;
  const std::size_t links = contacts.size() + springs;
  if (rank.row_entry.size() < ends ||
      (linked && (rank.contact_scatter.size() < ends || rank.link.size() < links))) {
    // The arrays may still be in use by the solve before.
    store_.devices()[r].compute().sync();
    rank.row_entry.grow(ends);
    if (linked) {
      rank.contact_scatter.grow(ends);
      rank.link.grow(links);
      rank.contact_gather.resize(rank.link.size());
    } else {
      // All corners that there is room for, to spare too, have that of their entries.
      rank.contact_column.resize(4 * rank.row_entry.size());
      rank.contact_value.resize(36 * rank.row_entry.size());
    }
  }
  launch(store_.devices()[r].compute(),
         AssembleContacts<T>{row_begin(r), row_count(r), store_.model().cloth_vertex_count,
                             contacts, rank.springs.span(), rank.iterate_positions.span(),
                             store_.rank(r).positions.span(), static_cast<T>(at.h), at.predicted,
                             rank.row_entry_count.span(), rank.row_entry.span(), rank.rhs.span(),
                             rank.contact_offset.span(), rank.contact_column.span(),
                             rank.contact_value.span(), rank.link.span(),
                             rank.contact_entry_count.span(), rank.contact_scatter.span()});
}

template <class T>
void LinearSystem<T>::set_springs(const std::vector<Spring<T>>& springs) {
  std::vector<Index> held = pinned_components_;
  for (const Spring<T>& s : springs) {
    const auto component = [this](Index v) {
      return component_of_vertex_[static_cast<std::size_t>(v)];
    };
    if (s.v[1] >= 0 && component(s.v[0]) == component(s.v[1])) continue;
    for (const Index v : s.v)
      if (v >= 0) held[static_cast<std::size_t>(component(v))] = 1;
  }
  for (int r = 0; r < store_.devices().size(); ++r) {
    Buffer<Spring<T>>& own = ranks_[static_cast<std::size_t>(r)].springs;
    if (own.size() + springs.size() > 0) upload(store_.devices()[r].compute(), own, springs);
    Buffer<Index>& held_always = ranks_[static_cast<std::size_t>(r)].held_always;
    if (held != held_always_ || held_always.size() == 0)
      upload(store_.devices()[r].compute(), held_always, held);
  }
  held_always_ = std::move(held);
}

template <class T>
void LinearSystem<T>::assemble_rank(int r, const Linearisation& at,
                                    Span<const Contact<T>> contacts) {
  assemble_elements(r, at);
  assemble_contacts_of(r, at, contacts);
  // Serves the step's later solves too: what changes by then hardly moves the aggregates.
  if (at.refresh) launch_coarse(r);
  launch_initial_guess(r, at, contacts);
}

template <class T>
void LinearSystem<T>::assemble_contacts_of(int r, const Linearisation& at,
                                           Span<const Contact<T>> contacts) {
  const auto n = static_cast<std::size_t>(r);
  Rank& rank = ranks_[n];
  Queue& queue = store_.devices()[r].compute();
  queue.copy(rank.rhs.data(), rank.mesh_rhs.data(), rank.rhs.size() * sizeof(Vec3<T>));
  assemble_contact_rows(r, at, contacts);
  launch(queue, Precondition<T>{row_begin(r), row_count(r), rank.diagonal.span(), contact_view(r),
                                geometry_[n].fixed.span(), rank.inverse.span()});
  launch(queue, SolveHalo<T>{r, geometry_[n].row_begin.span(), rank.mesh_ghost.span(),
                             contact_view(r), rank.stamp.span(), ++halo_epoch_, rank.ghost.span(),
                             rank.ghost_offset.span()});
}

/// Notes which components of cloth have fixed vertices.
template <class T>
void LinearSystem<T>::note_pins(const std::vector<unsigned char>& fixed) {
  pinned_components_.assign(geometry_[0].component_inverse_mass.size(), 0);
  for (std::size_t v = 0; v < component_of_vertex_.size(); ++v)
    if (fixed[v] != 0) pinned_components_[static_cast<std::size_t>(component_of_vertex_[v])] = 1;
}

/// Finds which components of cloth something holds.
template <class T>
void LinearSystem<T>::mark_held(int r, Span<const Contact<T>> contacts) {
  const auto n = static_cast<std::size_t>(r);
  Rank& rank = ranks_[n];
  Queue& queue = store_.devices()[r].compute();
  rank.held.resize(rank.held_always.size());
  queue.copy(rank.held.data(), rank.held_always.data(), rank.held.size() * sizeof(Index));
  if (!contacts.empty())
    launch(queue, SolveHeldComponents<T>{contacts, geometry_[n].component_of_vertex.span(),
                                         rank.held.span()});
}

template <class T>
void LinearSystem<T>::launch_initial_guess(int r, const Linearisation& at,
                                           Span<const Contact<T>> contacts) {
  const auto n = static_cast<std::size_t>(r);
  Rank& rank = ranks_[n];
  Span<const Vec3<T>> start;
  Span<const Index> held;
  if (at.predicted) {
    start = store_.rank(r).velocities.span();
    if (can_fall_) {
      mark_held(r, contacts);
      held = rank.held.span();
    }
  }
  launch(store_.devices()[r].compute(),
         SolveInitialGuess<T>{
             row_begin(r), row_count(r), motion_[n].positions_t1.span(),
             motion_[n].base_positions.span(), start, rank.iterate_velocities.span(),
             geometry_[n].fixed.span(), static_cast<T>(at.h), rank.x.span(), held,
             geometry_[n].component_of_vertex.span(), motion_[n].base_velocities.span(),
             geometry_[n].damping_mass.span(), vec_cast<T>(store_.scene().gravity)});
}

template <class T>
SolvePcgPart<T> LinearSystem<T>::part(int r) {
  const auto n = static_cast<std::size_t>(r);
  Rank& k = ranks_[n];
  SolvePcgPart<T> part;
  part.mesh = mesh_view(r);
  part.far = far_view(r);
  part.vertex = {k.vertex_mass.span(), k.vertex_drag.span()};
  part.contact = contact_view(r);
  part.inverse = k.inverse.span();
  for (int level = 0; level < schwarz_level_count; ++level)
    part.coarse[level] = coarse_level(r, level);
  part.fixed = geometry_[n].fixed.span();
  part.rhs = k.rhs.span();
  part.ghost = k.ghost.span();
  part.ghost_offset = k.ghost_offset.span();
  part.x = k.x.span();
  part.u = k.u.span();
  part.r = k.r.span();
  part.w = k.w.span();
  part.p = k.p.span();
  part.s = k.s.span();
  part.partial = k.partial.span();
  part.ready = k.ready.span();
  part.receivers = k.receivers.span();
  part.status = k.status.span();
  return part;
}

template <class T>
TrackedRows LinearSystem<T>::tracked_rows(const Linearisation& at) {
  Queue& queue = store_.devices()[0].compute();
  return tracked_->rows(download(queue, motion_.front().base_positions),
                        download(queue, ranks_.front().iterate_velocities), at.h);
}

/// Whether gravity is all that acts on the cloth of the assembled system.
template <class T>
bool LinearSystem<T>::all_fall() const {
  return can_fall_ && !ranks_[0].has_contacts && !held_always_.empty() &&
         std::all_of(held_always_.begin(), held_always_.end(),
                     [](Index held) { return held == 0; });
}

/// What gravity does to all cloth in a step, in the preconditioned norm. [sqrt(J)]
template <class T>
double LinearSystem<T>::fall_scale(double h) const {
  return length(store_.scene().gravity) * h * std::sqrt(store_.model().whole.mass);
}

/// Most that a solve with contacts may leave in the preconditioned norm. [sqrt(J)]
template <class T>
double LinearSystem<T>::left_with_contacts(double h) const {
  const Scene& scene = store_.scene();
  double left = misplaced_share * scene.contact.thickness / h;
  const double fallen = scene.solver.tolerance * length(scene.gravity) * h;
  const bool several = geometry_[0].component_inverse_mass.size() > 1;
  if (several && ranks_[0].springs.size() == 0 && fallen > 0) left = std::min(left, fallen);
  return left * std::sqrt(store_.model().whole.mass);
}

template <class T>
void LinearSystem<T>::launch_solve(const Linearisation& at, const SolveFloor& floor) {
  DeviceSet& devices = store_.devices();
  const SolverSettings& settings = store_.scene().solver;
  // Uploads of the last solve's parts are done: its outcome has been waited for.
  parts_.clear();
  for (int r = 0; r < devices.size(); ++r) parts_.push_back(part(r));
  if (tracked_ != nullptr) parts_.front().tracked = tracked_rows(at);
  // The initial guess of cloth that falls has gravity in it, but the tolerance is still a share of
  // that.
  const bool falls = at.predicted && all_fall();
  const double reference_min =
      falls ? std::max(floor.reference, weight_impulse(at.h)) : floor.reference;
  // Contacts and springs are the same on all ranks.
  const double left_max = ranks_[0].has_contacts ? left_with_contacts(at.h) : 0;
  std::vector<SolvePcg<T>> solves;
  for (int r = 0; r < devices.size(); ++r) {
    const auto n = static_cast<std::size_t>(r);
    solves.push_back({r, ranks_[n].parts.span(), geometry_[n].row_begin.span(), partial_rows(),
                      pcg_epoch_, settings.tolerance, reference_min, floor.scale, left_max,
                      settings.max_iterations, row_count(r),
                      settings.preconditioner != Preconditioner::block_jacobi,
                      ranks_[n].has_contacts && devices.backend() == Backend::cuda,
                      devices.stop_flag(), floor.accept, floor.gain, falls ? fall_scale(at.h) : 0});
  }
  if (pipelined_ && tracked_ == nullptr) {
    pipelined_->solve(solves, parts_);
  } else {
    for (int r = 0; r < devices.size(); ++r)
      devices[r].compute().copy(ranks_[static_cast<std::size_t>(r)].parts.data(), parts_.data(),
                                parts_.size() * sizeof(SolvePcgPart<T>));
    join_ranks(devices);
    launch_collective(devices, solves);
  }
  for (int r = 0; r < devices.size(); ++r) {
    const auto n = static_cast<std::size_t>(r);
    launch(devices[r].compute(),
           IntegrateUpdate<T>{row_begin(r), row_count(r), ranks_[n].iterate_velocities.span(),
                              ranks_[n].x.span(), T(1), motion_[n].velocities_t1.span()});
  }
  pcg_epoch_ += pcg_epochs(settings.max_iterations);
}

template <class T>
void LinearSystem<T>::begin_line() {
  const auto step = static_cast<std::size_t>(store_.partition().partial_rows);
  for (int r = 0; r < store_.devices().size(); ++r) {
    Rank& rank = ranks_[static_cast<std::size_t>(r)];
    Queue& queue = store_.devices()[r].compute();
    if (rank.line_start.size() == 0) {
      const MemoryName name("solver");
      Device& device = store_.devices()[r];
      rank.line_start = Buffer<Vec3<T>>(device, rank.x.size());
      rank.line_direction = Buffer<Vec3<T>>(device, rank.x.size());
      rank.line_partial =
          Buffer<double>(device, 2 * ((static_cast<std::size_t>(row_count(r)) + step - 1) / step));
    }
    const std::size_t bytes = rank.x.size() * sizeof(Vec3<T>);
    queue.copy(rank.line_start.data(), rank.iterate_velocities.data(), bytes);
    queue.copy(rank.line_direction.data(), rank.x.data(), bytes);
  }
}

template <class T>
void LinearSystem<T>::move_along(double share) {
  for (int r = 0; r < store_.devices().size(); ++r) {
    const Rank& rank = ranks_[static_cast<std::size_t>(r)];
    launch(store_.devices()[r].compute(),
           IntegrateUpdate<T>{row_begin(r), row_count(r), rank.line_start.span(),
                              rank.line_direction.span(), static_cast<T>(share),
                              motion_[static_cast<std::size_t>(r)].velocities_t1.span()});
  }
}

template <class T>
ResidualProducts LinearSystem<T>::products() {
  DeviceSet& devices = store_.devices();
  std::vector<std::vector<double>> partials;
  for (int r = 0; r < devices.size(); ++r) {
    const auto n = static_cast<std::size_t>(r);
    const Rank& rank = ranks_[n];
    launch(devices[r].compute(),
           SolveProducts<T>{row_begin(r), row_count(r), store_.partition().partial_rows,
                            rank.rhs.span(), rank.line_direction.span(), geometry_[n].fixed.span(),
                            rank.line_partial.span()});
    partials.emplace_back(rank.line_partial.size());
    devices[r].compute().copy(partials.back().data(), rank.line_partial.data(),
                              partials.back().size() * sizeof(double));
  }
  sync_ranks(devices);
  ResidualProducts sum;
  for (const auto& of_rank : partials)
    for (std::size_t k = 0; k < of_rank.size(); k += 2) {
      sum.slope += of_rank[k];
      sum.residual += of_rank[k + 1];
    }
  sum.residual = std::sqrt(sum.residual);
  return sum;
}

template <class T>
StepEnergy LinearSystem<T>::step_energy() {
  std::vector<Span<const Vec3<T>>> positions, velocities;
  for (int r = 0; r < store_.devices().size(); ++r) {
    positions.push_back(store_.rank(r).positions.span());
    velocities.push_back(store_.rank(r).velocities.span());
  }
  return step_energy(positions, velocities);
}

template <class T>
StepEnergy LinearSystem<T>::step_energy(const std::vector<Span<const Vec3<T>>>& positions,
                                        const std::vector<Span<const Vec3<T>>>& velocities) {
  DeviceSet& devices = store_.devices();
  const Index partial_rows = store_.partition().partial_rows;
  std::vector<std::vector<double>> partials;
  for (int r = 0; r < devices.size(); ++r) {
    const auto n = static_cast<std::size_t>(r);
    Rank& rank = ranks_[n];
    Queue& queue = devices[r].compute();
    if (rank.energy_partial.size() == 0) {
      const MemoryName name("solver");
      const Index count = (row_count(r) + partial_rows - 1) / partial_rows;
      rank.stretch_error = Buffer<StretchError<T>>(devices[r], rank.triangles.size());
      rank.energy_partial = Buffer<double>(devices[r], 3 * static_cast<std::size_t>(count));
    }
    launch(queue,
           AssembleStretchError<T>{rank.triangles.span(), rank.inv_rest.span(), rank.area.span(),
                                   rank.material.span(), rank.materials.span(), positions[n],
                                   motion_[n].positions_t1.span(), rank.stretch_error.span(),
                                   rank.compression.span()});
    launch(queue, AssembleStepEnergy<T>{row_begin(r), row_count(r), partial_rows,
                                        geometry_[n].mass.span(), velocities[n],
                                        rank.corner_source_offset.span(), rank.corner_source.span(),
                                        rank.stretch_error.span(), rank.energy_partial.span()});
    partials.emplace_back(rank.energy_partial.size());
    queue.copy(partials.back().data(), rank.energy_partial.data(),
               partials.back().size() * sizeof(double));
  }
  sync_ranks(devices);
  StepEnergy sum;
  for (const auto& of_rank : partials)
    for (std::size_t k = 0; k < of_rank.size(); k += 3) {
      sum.at_start += of_rank[k];
      sum.turned += of_rank[k + 1];
      sum.limited += of_rank[k + 2];
    }
  return sum;
}

template <class T>
double LinearSystem<T>::kinetic_energy() {
  std::vector<Span<const Vec3<T>>> positions, velocities;
  for (int r = 0; r < store_.devices().size(); ++r) {
    RankState<T>& state = store_.rank(r);
    Rank& rank = ranks_[static_cast<std::size_t>(r)];
    if (rank.no_velocities.size() != state.velocities.size()) {
      const MemoryName name("solver");
      rank.no_velocities = Buffer<Vec3<T>>(store_.devices()[r], state.velocities.size());
      store_.devices()[r].compute().fill(rank.no_velocities.data(), 0,
                                         rank.no_velocities.size() * sizeof(Vec3<T>));
    }
    positions.push_back(state.positions.span());
    velocities.push_back(rank.no_velocities.span());
  }
  return step_energy().at_start - step_energy(positions, velocities).at_start;
}

template <class T>
SolveStatus LinearSystem<T>::status() {
  SolveStatus status;
  Queue& queue = store_.devices()[0].compute();
  queue.copy(&status, ranks_[0].status.data(), sizeof status);
  queue.sync();
  return status;
}

template class LinearSystem<float>;
template class LinearSystem<double>;

}  // namespace weft
