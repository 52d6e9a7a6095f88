#include "host/implicit/linear_system.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "host/implicit/exchange.hpp"
#include "weft/kernels/assemble/bending.hpp"
#include "weft/kernels/assemble/contacts.hpp"
#include "weft/kernels/assemble/rows.hpp"
#include "weft/kernels/respond/update.hpp"
#include "weft/kernels/solve/guess.hpp"
#include "weft/kernels/solve/halo.hpp"
#include "weft/kernels/solve/precondition.hpp"

namespace weft {
namespace {

/// Residuals are judged against at least this share of what gravity does in a step: at a tolerance
/// of 1e-3 that leaves velocities wrong by 1e-4 of h g.
constexpr double weight_share = 0.1;

/// The items of `all` that `chosen` names.
template <class T>
std::vector<T> pick(const std::vector<T>& all, const std::vector<Index>& chosen) {
  std::vector<T> out;
  out.reserve(chosen.size());
  for (const Index i : chosen) out.push_back(all[static_cast<std::size_t>(i)]);
  return out;
}

}  // namespace

template <class T>
LinearSystem<T>::LinearSystem(Store<T>& store, std::vector<RankGeometry<T>>& geometry,
                              std::vector<RankMotion<T>>& motion)
    : store_(store), geometry_(geometry), motion_(motion), ranks_(geometry.size()) {
  for (int r = 0; r < store.devices().size(); ++r) make_rank(r);
  double mass_sq = 0;
  for (const double m : store.model().mass) mass_sq += m * m;
  weight_ = std::sqrt(mass_sq) * length(store.scene().gravity);
}

template <class T>
void LinearSystem<T>::make_elements(int r, const MeshRows& rows) {
  const Model& m = store_.model();
  Device& device = store_.devices()[r];
  Rank& rank = ranks_[static_cast<std::size_t>(r)];
  const auto put = [&](auto& buffer, const auto& values) {
    buffer = std::remove_reference_t<decltype(buffer)>(device);
    upload(device.compute(), buffer, values);
  };
  std::vector<Mat2<T>> inv_rest;
  for (const Index t : rows.triangles) {
    Mat2<T> q;
    for (int k = 0; k < 4; ++k)
      q.e[k] = static_cast<T>(m.inv_rest[static_cast<std::size_t>(t)].e[k]);
    inv_rest.push_back(q);
  }
  std::vector<MaterialRow<T>> materials;
  for (const Material& material : store_.scene().materials)
    materials.push_back({membrane_constants(static_cast<T>(material.stretch_stiffness),
                                            static_cast<T>(material.poisson_ratio)),
                         static_cast<T>(material.damping_stiffness)});
  put(rank.triangles, pick(m.triangles, rows.triangles));
  put(rank.inv_rest, inv_rest);
  put(rank.area, cast_all<T>(pick(m.area, rows.triangles)));
  put(rank.material, pick(m.material, rows.triangles));
  put(rank.materials, materials);
  put(rank.hinges, pick(m.hinges, rows.hinges));
  put(rank.hinge_stiffness, cast_all<T>(pick(m.hinge_stiffness, rows.hinges)));
  put(rank.hinge_rest_angle, cast_all<T>(pick(m.hinge_rest_angle, rows.hinges)));
  put(rank.hinge_damping, cast_all<T>(pick(m.hinge_damping, rows.hinges)));
  put(rank.slice_offset, rows.slice_offset);
  put(rank.column, rows.column);
  put(rank.block_source_offset, rows.block_source_offset);
  put(rank.block_source, rows.block_source);
  put(rank.corner_source_offset, rows.corner_source_offset);
  put(rank.corner_source, rows.corner_source);
  put(rank.mesh_ghost, rows.ghost);
}

template <class T>
void LinearSystem<T>::make_rank(int r) {
  const MeshRows rows = make_mesh_rows(store_.model(), store_.partition(), r);
  make_elements(r, rows);
  Device& device = store_.devices()[r];
  Rank& rank = ranks_[static_cast<std::size_t>(r)];
  const auto make = [&](auto& buffer, std::size_t size) {
    buffer = std::remove_reference_t<decltype(buffer)>(device, size);
  };
  const auto own = static_cast<std::size_t>(row_count(r));
  const auto cloth = static_cast<std::size_t>(store_.model().cloth_vertex_count);
  const auto all = static_cast<std::size_t>(store_.model().vertex_count);
  const auto step = static_cast<std::size_t>(store_.partition().partial_rows);
  make(rank.triangle_impulse, 3 * rows.triangles.size());
  make(rank.triangle_block, 6 * rows.triangles.size());
  make(rank.hinge_direction, 4 * rows.hinges.size());
  make(rank.hinge_impulse_scale, rows.hinges.size());
  make(rank.hinge_curvature, rows.hinges.size());
  make(rank.value, 9 * rows.column.size());
  make(rank.row_entry_count, own + 1);
  make(rank.row_entry, 1024);
  make(rank.contact_offset, own + 1);
  make(rank.contact_column, 1024);
  make(rank.contact_value, 1024);
  make(rank.iterate_positions, all);
  make(rank.iterate_velocities, cloth);
  for (auto* buffer : {&rank.mesh_rhs, &rank.rhs, &rank.r, &rank.w, &rank.p, &rank.s})
    make(*buffer, own);
  make(rank.inverse, own);
  make(rank.x, cloth);
  make(rank.u, cloth);
  make(rank.stamp, cloth);
  make(rank.ghost, cloth);
  make(rank.ghost_offset, static_cast<std::size_t>(store_.devices().size()) + 1);
  make(rank.partial, 6 * ((cloth + step - 1) / step));
  make(rank.ready, 2);
  make(rank.status, 1);
  make(rank.parts, ranks_.size());
  device.compute().fill(rank.stamp.data(), 0, cloth * sizeof(Index));
  device.compute().fill(rank.ready.data(), 0, 2 * sizeof(std::uint32_t));
  device.compute().sync();
}

template <class T>
BlockEll<T> LinearSystem<T>::mesh_view(int r) const {
  const Rank& rank = ranks_[static_cast<std::size_t>(r)];
  return {row_count(r), mesh_slice, rank.slice_offset.span(), rank.column.span(),
          rank.value.span()};
}

template <class T>
BlockEll<T> LinearSystem<T>::contact_view(int r) const {
  const Rank& rank = ranks_[static_cast<std::size_t>(r)];
  if (!rank.has_contacts) return {};
  return {row_count(r), 1, rank.contact_offset.span(), rank.contact_column.span(),
          rank.contact_value.span()};
}

template <class T>
void LinearSystem<T>::assemble_elements(int r, const Linearisation<T>& at) {
  const auto n = static_cast<std::size_t>(r);
  Rank& rank = ranks_[n];
  Queue& queue = store_.devices()[r].compute();
  Span<const Vec3<T>> velocities;
  if (!at.iterate_at_rest) velocities = rank.iterate_velocities.span();
  const auto h = static_cast<T>(at.h);
  launch(queue, AssembleMembrane<T>{rank.triangles.span(), rank.inv_rest.span(), rank.area.span(),
                                    rank.material.span(), rank.materials.span(),
                                    rank.iterate_positions.span(), velocities, h,
                                    rank.triangle_impulse.span(), rank.triangle_block.span()});
  launch(queue, AssembleBending<T>{rank.hinges.span(), rank.hinge_stiffness.span(),
                                   rank.hinge_rest_angle.span(), rank.hinge_damping.span(),
                                   rank.iterate_positions.span(), velocities, h,
                                   rank.hinge_direction.span(), rank.hinge_impulse_scale.span(),
                                   rank.hinge_curvature.span()});
  const Vec3<double>& g = store_.scene().gravity;
  launch(queue, AssembleRows<T>{row_begin(r),
                                {row_count(r), mesh_slice, rank.slice_offset.span(),
                                 rank.column.span(), rank.value.span()},
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
                                rank.mesh_rhs.span()});
}

template <class T>
void LinearSystem<T>::assemble_contact_rows(int r, const Linearisation<T>& at,
                                            Span<const Contact<T>> contacts) {
  const auto n = static_cast<std::size_t>(r);
  Rank& rank = ranks_[n];
  rank.has_contacts = !contacts.empty();
  if (!rank.has_contacts) return;
  if (rank.contact_column.size() < 16 * contacts.size()) {
    // The arrays may still be in use by the solve before.
    store_.devices()[r].compute().sync();
    rank.row_entry.grow(4 * contacts.size());
    rank.contact_column.grow(16 * contacts.size());
    rank.contact_value.grow(9 * 16 * contacts.size());
  }
  launch(store_.devices()[r].compute(),
         AssembleContacts<T>{
             row_begin(r), row_count(r), store_.model().cloth_vertex_count, contacts,
             rank.iterate_positions.span(), store_.rank(r).positions.span(), static_cast<T>(at.h),
             static_cast<T>(slip_speed * store_.scene().time.step), at.iteration == 0,
             rank.row_entry_count.span(), rank.row_entry.span(), rank.contact_offset.span(),
             rank.contact_column.span(), rank.contact_value.span(), rank.rhs.span()});
}

template <class T>
void LinearSystem<T>::assemble_rank(int r, const Linearisation<T>& at,
                                    Span<const Contact<T>> contacts) {
  assemble_elements(r, at);
  assemble_contacts_of(r, at, contacts);
  launch_guess(r, at);
}

template <class T>
void LinearSystem<T>::assemble_contacts_of(int r, const Linearisation<T>& at,
                                           Span<const Contact<T>> contacts) {
  const auto n = static_cast<std::size_t>(r);
  Rank& rank = ranks_[n];
  Queue& queue = store_.devices()[r].compute();
  queue.copy(rank.rhs.data(), rank.mesh_rhs.data(), rank.rhs.size() * sizeof(Vec3<T>));
  assemble_contact_rows(r, at, contacts);
  launch(queue, Precondition<T>{row_begin(r), mesh_view(r), contact_view(r),
                                geometry_[n].fixed.span(), rank.inverse.span()});
  Span<const Offset> contact_offset;
  if (rank.has_contacts) contact_offset = rank.contact_offset.span();
  launch(queue, SolveHalo{r, geometry_[n].row_begin.span(), rank.mesh_ghost.span(), contact_offset,
                          rank.contact_column.span(), rank.stamp.span(), ++halo_epoch_,
                          rank.ghost.span(), rank.ghost_offset.span()});
}

template <class T>
void LinearSystem<T>::launch_guess(int r, const Linearisation<T>& at) {
  const auto n = static_cast<std::size_t>(r);
  Rank& rank = ranks_[n];
  Span<const Vec3<T>> start;
  Span<const Vec3<T>> iterate;
  if (at.iteration == 0) start = store_.rank(r).velocities.span();
  if (!at.iterate_at_rest) iterate = rank.iterate_velocities.span();
  launch(store_.devices()[r].compute(),
         SolveGuess<T>{row_begin(r), row_count(r), motion_[n].positions_t1.span(),
                       motion_[n].base_positions.span(), start, iterate, geometry_[n].fixed.span(),
                       static_cast<T>(at.h), rank.x.span()});
}

template <class T>
SolvePcgPart<T> LinearSystem<T>::part(int r) {
  const auto n = static_cast<std::size_t>(r);
  Rank& k = ranks_[n];
  return {mesh_view(r),
          contact_view(r),
          k.inverse.span(),
          geometry_[n].fixed.span(),
          k.rhs.span(),
          k.ghost.span(),
          k.ghost_offset.span(),
          k.x.span(),
          k.u.span(),
          k.r.span(),
          k.w.span(),
          k.p.span(),
          k.s.span(),
          k.partial.span(),
          k.ready.span(),
          k.status.span()};
}

template <class T>
void LinearSystem<T>::launch_solve(const Linearisation<T>& at, double reference_min) {
  DeviceSet& devices = store_.devices();
  const SolverSettings& settings = store_.scene().solver;
  // Uploads of the last solve's parts are done: its outcome has been waited for.
  parts_.clear();
  for (int r = 0; r < devices.size(); ++r) parts_.push_back(part(r));
  for (int r = 0; r < devices.size(); ++r)
    devices[r].compute().copy(ranks_[static_cast<std::size_t>(r)].parts.data(), parts_.data(),
                              parts_.size() * sizeof(SolvePcgPart<T>));
  join_ranks(devices);
  for (int r = 0; r < devices.size(); ++r) {
    const auto n = static_cast<std::size_t>(r);
    launch(devices[r].compute(),
           SolvePcg<T>{r, ranks_[n].parts.span(), geometry_[n].row_begin.span(),
                       store_.partition().partial_rows, pcg_epoch_, settings.tolerance,
                       std::max(reference_min, weight_share * at.h * weight_),
                       settings.max_iterations});
    Span<const Vec3<T>> iterate;
    if (!at.iterate_at_rest) iterate = ranks_[n].iterate_velocities.span();
    launch(devices[r].compute(),
           RespondUpdate<T>{row_begin(r), row_count(r), iterate, ranks_[n].x.span(), T(1),
                            motion_[n].velocities_t1.span()});
  }
  pcg_epoch_ += pcg_epochs(settings.max_iterations);
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
