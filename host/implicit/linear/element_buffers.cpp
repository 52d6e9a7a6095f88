#include "host/implicit/linear/element_buffers.hpp"

#include "host/implicit/linear/rank_rows.hpp"
#include "host/model/material_rows.hpp"
#include "weft/kernels/assemble/bending.hpp"
#include "weft/kernels/assemble/pressure.hpp"
#include "weft/kernels/assemble/wind.hpp"

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

/// The same in run precision; empty where there are none at all.
template <class T>
std::vector<T> pick_any(const std::vector<double>& all, const std::vector<Index>& chosen) {
  return all.empty() ? std::vector<T>{} : cast_all<T>(pick(all, chosen));
}

}  // namespace

template <class T>
void ElementBuffers<T>::make(Device& device, const Scene& scene, const Model& m,
                             const MeshRows& rows) {
  const MemoryName name("elements");
  put(device, triangles, pick(m.triangles, rows.triangles));
  put(device, inv_rest, cast_all<T>(pick(m.inv_rest, rows.triangles)));
  put(device, area, cast_all<T>(pick(m.area, rows.triangles)));
  put(device, pressure, pick_any<T>(m.pressure, rows.triangles));
  numbers = rows.triangles;
  compression = Buffer<T>(device);
  put(device, material, pick(m.material, rows.triangles));
  const MaterialRows<T>& laws = m.laws->template in<T>();
  put(device, materials, laws.rows);
  put(device, material_tables, laws.tables);
  put(device, hinges, pick(m.hinges, rows.hinges));
  put(device, hinge_stiffness, cast_all<T>(pick(m.hinge_stiffness, rows.hinges)));
  put(device, hinge_rest_angle, cast_all<T>(pick(m.hinge_rest_angle, rows.hinges)));
  put(device, hinge_damping, cast_all<T>(pick(m.hinge_damping, rows.hinges)));
  weft::make(device, triangle_impulse, 3 * rows.triangles.size());
  weft::make(device, triangle_block, 6 * rows.triangles.size());
  weft::make(device, corner_drag, blows(scene.wind) ? rows.triangles.size() : 0);
  weft::make(device, hinge_direction, 4 * rows.hinges.size());
  weft::make(device, hinge_impulse_scale, rows.hinges.size());
  weft::make(device, hinge_curvature, rows.hinges.size());
}

template <class T>
void ElementBuffers<T>::take_compression(Queue& queue, const std::vector<double>& of_model) {
  upload(queue, compression, pick_any<T>(of_model, numbers));
}

template <class T>
void ElementBuffers<T>::assemble(Queue& queue, const Wind& wind, const RankState<T>& state,
                                 const At& at) {
  launch(queue, AssembleMembrane<T>{triangles.span(), inv_rest.span(), area.span(), material.span(),
                                    materials.span(), at.positions, at.rates, at.h,
                                    triangle_impulse.span(), triangle_block.span(),
                                    material_tables.span(), compression.span(), at.start});
  if (pressure.size() > 0)
    launch(queue, AssemblePressure<T>{triangles.span(), pressure.span(), at.positions, at.h,
                                      triangle_impulse.span()});
  if (blows(wind))
    launch(queue,
           AssembleWind<T>{triangles.span(), state.positions.span(), state.velocities.span(),
                           at.velocities, static_cast<T>(wind.density), static_cast<T>(wind.drag),
                           vec_cast<T>(wind.velocity), at.h, triangle_impulse.span(),
                           triangle_block.span(), corner_drag.span()});
  launch(queue, AssembleBending<T>{hinges.span(), hinge_stiffness.span(), hinge_rest_angle.span(),
                                   hinge_damping.span(), at.positions, at.rates, at.h,
                                   hinge_direction.span(), hinge_impulse_scale.span(),
                                   hinge_curvature.span()});
}

template <class T>
void ElementBuffers<T>::launch_stretch_error(Queue& queue, Span<const Vec3<T>> positions_t0,
                                             Span<const Vec3<T>> positions_t1,
                                             Span<StretchError<T>> error,
                                             const TurnedStart<T>& start) const {
  launch(queue, AssembleStretchError<T>{triangles.span(), inv_rest.span(), area.span(),
                                        material.span(), materials.span(), positions_t0,
                                        positions_t1, error, compression.span(), start});
}

template struct ElementBuffers<float>;
template struct ElementBuffers<double>;

}  // namespace weft
