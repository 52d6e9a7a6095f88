#include "host/implicit/external_work.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/model/material_rows.hpp"
#include "host/model/springs.hpp"
#include "weft/core/at.hpp"
#include "weft/elements/spring.hpp"
#include "weft/elements/triangle_frame.hpp"
#include "weft/kernels/assemble/bending.hpp"
#include "weft/kernels/assemble/membrane.hpp"
#include "weft/kernels/integrate/gather.hpp"

namespace weft {
namespace {

/// What the spring sees of the vector between its ends. [m]
Vec3<double> span_of(const Spring<double>& s, const std::vector<Vec3<double>>& x) {
  return spring_span(x[at(s.v[0])] - (s.v[1] < 0 ? s.anchor : x[at(s.v[1])]), s.along);
}

double energy_of(const Spring<double>& s, const std::vector<Vec3<double>>& x) {
  return spring_energy(span_of(s, x), s.rest, s.stiffness);
}

Vec3<double> force_of(const Spring<double>& s, const std::vector<Vec3<double>>& x) {
  return spring_force(span_of(s, x), s.rest, s.stiffness);
}

/// Of the spring's dashpot, against the motion of its first end.
Vec3<double> drag_of(const Spring<double>& s, const std::vector<Vec3<double>>& x0,
                     const std::vector<Vec3<double>>& x1) {
  if (!(s.drag > 0)) return {};
  const Vec3<double> before = span_of(s, x0);
  return spring_drag(before, s.rest, s.drag) * (span_of(s, x1) - before);
}

bool same_ends(const std::vector<Spring<double>>& a, const std::vector<Spring<double>>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const Spring<double>& s, const Spring<double>& t) {
                      return s.v[0] == t.v[0] && s.v[1] == t.v[1];
                    });
}

void keep_each_once(std::vector<Index>& vertices) {
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
}

/// Energy that the curved rest shape of a plate's triangle adds, see PlateShape.
double shape_energy(const PlateShape& shape, std::size_t t, const std::vector<Vec3<double>>& x) {
  Vec3<double> corner[3];
  for (int j = 0; j < 3; ++j) corner[j] = x[at(shape.corners[t].v[j])];
  const TriangleFrame<double> frame = triangle_frame(corner, shape.inv_rest[t]);
  double sum = 0;
  for (auto e = static_cast<std::size_t>(shape.offset[t]);
       e < static_cast<std::size_t>(shape.offset[t + 1]); ++e)
    sum -= dot(x[at(shape.vertex[e])] - corner[0], from_frame(frame, shape.force[e]));
  return sum;
}

}  // namespace

template <class T>
ExternalWork<T>::ExternalWork(Store<T>& store, const std::vector<RankGeometry<T>>& geometry)
    : store_(store),
      geometry_(geometry),
      pressure_(store.devices()[0]),
      partial_(store.devices()[0]),
      chosen_on_device_(store.devices()[0]),
      met_(store.devices()[0]),
      gathered_(store.devices()[0]) {
  const Scene& scene = store.scene();
  const Model& model = store.model();
  bodies_ = scene.contact.compliance_distance.value_or(0) > 0 ||
            std::any_of(scene.obstacles.begin(), scene.obstacles.end(), obstacle_moves);
  pins_ = std::any_of(scene.pins.begin(), scene.pins.end(), [&](const Pin& p) {
    return pin_moves(p) || scene.contact.compliance_distance.value_or(0) > 0 ||
           (p.obstacle >= 0 && obstacle_moves(scene.obstacles[at(p.obstacle)]));
  });
  springs_ = !scene.handles.empty() || !scene.seams.empty();
  const bool wind = scene.wind.density > 0 || scene.wind.drag > 0;
  air_ = wind || !model.pressure.empty();
  any_ = bodies_ || pins_ || springs_ || air_;
  if (!model.pressure.empty())
    upload(store.devices()[0].compute(), pressure_, cast_all<T>(model.pressure));
}

/// @param vertices in the memory of rank 0
template <class T>
std::vector<Vec3<T>> ExternalWork<T>::fetch(Span<const Index> vertices, Span<const Vec3<T>> from) {
  std::vector<Vec3<T>> to(vertices.size());
  if (to.empty()) return to;
  Queue& queue = store_.devices()[0].compute();
  gathered_.grow(to.size());
  launch(queue, IntegrateGather<T>{vertices, from, gathered_.span().subspan(0, vertices.size())});
  queue.copy(to.data(), gathered_.data(), to.size() * sizeof(Vec3<T>));
  queue.sync();
  return to;
}

/// @param vertices in any order, some perhaps several times
template <class T>
void ExternalWork<T>::choose(std::vector<Index> vertices) {
  keep_each_once(vertices);
  if (vertices == chosen_) return;
  chosen_ = std::move(vertices);
  upload(store_.devices()[0].compute(), chosen_on_device_, chosen_);
  for (Vectors* all : {&x0_, &x1_, &v0_, &v1_, &v_end_, &linear_about_})
    all->resize(at(store_.model().vertex_count));
}

template <class T>
void ExternalWork<T>::fetch_chosen(Span<const Vec3<T>> from, Vectors& to) {
  const std::vector<Vec3<T>> gathered = fetch(chosen_on_device_.span(), from);
  for (std::size_t k = 0; k < chosen_.size(); ++k)
    to[at(chosen_[k])] = vec_cast<double>(gathered[k]);
}

template <class T>
double ExternalWork<T>::of(const AcceptedMotion<T>& motion) {
  // The state may come from another scene, with bodies and pins in other places.
  const bool other_state = restores_ != store_.restores();
  restores_ = store_.restores();
  const bool applied = !store_.accelerations().empty();
  if (!any_ && !applied && !other_state) return 0;
  const bool bodies = bodies_ || other_state;
  const bool pins = pins_ || (other_state && !store_.scene().pins.empty());
  double work = 0;
  if (air_) work += of_air(motion);
  if (applied) work += of_applied_forces(motion);
  if ((bodies || pins) && !motion.contacts.empty()) work += of_contacts(motion);
  if ((bodies || pins) && !motion.collisions->empty()) work += of_zones(motion);
  const Springs springs = find_springs(motion);
  const bool pull = !springs.before.empty() || !springs.after.empty();
  if (!pins && !pull) return work;
  std::vector<Index> vertices;
  if (pins) {
    find_pins(*motion.fixed);
    vertices = at_pins_.around;
  }
  for (const auto* list : {&springs.before, &springs.after})
    for (const Spring<double>& s : *list)
      for (const Index v : s.v)
        if (v >= 0) vertices.push_back(v);
  choose(std::move(vertices));
  if (chosen_.empty()) return work;
  fetch_chosen(store_.rank(0).positions.span(), x0_);
  fetch_chosen(motion.positions_solved, x1_);
  if (pins) work += of_pins(motion);
  if (pull) work += of_springs(springs, motion);
  return work;
}

template <class T>
double ExternalWork<T>::sum_up(AssembleExternalWork<T> args) {
  args.fixed = geometry_[0].fixed.span();
  args.positions_t0 = store_.rank(0).positions.span();
  args.velocities_t0 = store_.rank(0).velocities.span();
  const std::size_t count = at(args.partials());
  partial_.grow(count);
  args.partial = partial_.span();
  Queue& queue = store_.devices()[0].compute();
  launch(queue, args);
  std::vector<double> partials(count);
  queue.copy(partials.data(), partial_.data(), count * sizeof(double));
  queue.sync();
  double sum = 0;
  for (const double partial : partials) sum += partial;
  return sum;
}

/// Contacts that push bodies away may have been compressed before, and then it is not the cloth
/// whose energy goes. So all of it counts as none.
template <class T>
double ExternalWork<T>::of_contacts(const AcceptedMotion<T>& motion) {
  AssembleExternalWork<T> args;
  args.contacts = motion.contacts;
  args.positions_t1 = motion.positions_solved;
  return std::max(0.0, sum_up(args));
}

/// Of wind and pressure.
template <class T>
double ExternalWork<T>::of_air(const AcceptedMotion<T>& motion) {
  const Wind& wind = store_.scene().wind;
  AssembleExternalWork<T> args;
  args.triangles =
      geometry_[0].triangles.span().subspan(0, at(store_.model().cloth_triangle_count));
  args.pressure = pressure_.span();
  args.positions_t1 = motion.positions_solved;
  args.velocities_t1 = motion.velocities_solved;
  args.density = static_cast<T>(wind.density);
  args.drag = static_cast<T>(wind.drag);
  args.wind = vec_cast<T>(wind.velocity);
  return sum_up(args);
}

template <class T>
double ExternalWork<T>::of_applied_forces(const AcceptedMotion<T>& motion) {
  AssembleExternalWork<T> args;
  args.accelerations = store_.rank(0).accelerations.span();
  args.mass = geometry_[0].mass.span();
  args.positions_t1 = motion.positions;
  return sum_up(args);
}

template <class T>
void ExternalWork<T>::find_pins(const std::vector<unsigned char>& fixed) {
  if (fixed == fixed_) return;
  fixed_ = fixed;
  at_pins_ = {};
  const Model& model = store_.model();
  const auto pinned = [&](Index v) { return fixed[at(v)] != 0; };
  for (Index v = 0; v < model.cloth_vertex_count; ++v)
    if (pinned(v)) at_pins_.vertices.push_back(v);
  for (Index t = 0; t < model.cloth_triangle_count; ++t) {
    const Index* v = model.triangles[at(t)].v;
    if (std::any_of(v, v + 3, pinned)) at_pins_.triangles.push_back(t);
  }
  for (std::size_t h = 0; h < model.hinges.size(); ++h) {
    const Index* v = model.hinges[h].v;
    if (std::any_of(v, v + 4, pinned)) at_pins_.hinges.push_back(static_cast<Index>(h));
  }
  const auto plate = store_.plate(fixed);
  const PlateShape& shape = plate->shape;
  for (std::size_t t = 0; t < shape.corners.size(); ++t)
    if (std::any_of(shape.vertex.begin() + static_cast<std::ptrdiff_t>(shape.offset[t]),
                    shape.vertex.begin() + static_cast<std::ptrdiff_t>(shape.offset[t + 1]),
                    pinned))
      at_pins_.shapes.push_back(static_cast<Index>(t));
  std::vector<Index>& around = at_pins_.around;
  const auto add = [&](const auto& from, std::size_t first, std::size_t last) {
    around.insert(around.end(), from + static_cast<std::ptrdiff_t>(first),
                  from + static_cast<std::ptrdiff_t>(last));
  };
  around = at_pins_.vertices;
  for (const Index t : at_pins_.triangles) add(model.triangles[at(t)].v, 0, 3);
  for (const Index h : at_pins_.hinges) add(model.hinges[at(h)].v, 0, 4);
  for (const Index t : at_pins_.shapes)
    add(shape.vertex.begin(), static_cast<std::size_t>(shape.offset[at(t)]),
        static_cast<std::size_t>(shape.offset[at(t) + 1]));
  if (!plate->row_offset.empty())
    for (const Index v : at_pins_.vertices)
      add(plate->column.begin(), static_cast<std::size_t>(plate->row_offset[at(v)]),
          static_cast<std::size_t>(plate->row_offset[at(v) + 1]));
}

template <class T>
typename ExternalWork<T>::Springs ExternalWork<T>::find_springs(
    const AcceptedMotion<T>& motion) const {
  if (!springs_) return {};
  return {springs_at(store_.scene(), store_.model(), store_.time),
          springs_at(store_.scene(), store_.model(), store_.time + motion.dt, motion.dt)};
}

/// Pins give energy to the pinned vertices and hold them against the forces of elements. Forces
/// that a linear solve does not know pull at pins in the next step. The residual of Newton's method
/// may act on the cloth beside the pins, so its work counts too.
template <class T>
double ExternalWork<T>::of_pins(const AcceptedMotion<T>& motion) {
  const Model& model = store_.model();
  fetch_chosen(store_.rank(0).velocities.span(), v0_);
  fetch_chosen(motion.velocities_solved, v1_);
  fetch_chosen(motion.velocities, v_end_);
  const Vectors &x0 = x0_, &x1 = x1_, &v0 = v0_, &v1 = v1_, &v_end = v_end_;
  const auto moved = [&](Index v) {
    return fixed_[at(v)] != 0 ? x1[at(v)] - x0[at(v)] : Vec3<double>{};
  };
  double moved_sq = 0;
  for (const Index v : at_pins_.vertices) moved_sq += length_sq(moved(v));
  double work = motion.residual * std::sqrt(moved_sq) / motion.dt;
  for (const Index v : at_pins_.vertices)
    work += model.mass[at(v)] * ((length_sq(v_end[at(v)]) - length_sq(v0[at(v)])) / 2 -
                                 dot(store_.scene().gravity, moved(v)));
  const bool linear = !motion.linear_about.empty();
  if (linear) fetch_chosen(motion.linear_about, linear_about_);
  const Vectors& x_at = linear ? linear_about_ : x1;
  // Displacements from there that forces are linear in, with those that damping b amounts to.
  const auto displaced = [&](Index v, double damping) {
    const Vec3<double> rate = damping * v1[at(v)];
    return linear ? x1[at(v)] - x_at[at(v)] + rate : rate;
  };
  const MaterialRows<double>& laws = model.laws->rows;
  const Tri corners{{0, 1, 2}};
  const Index only = 0;
  for (const Index t : at_pins_.triangles) {
    Vec3<double> x[3], u[3], force[3];
    Mat3<double> block[6];
    MaterialRow<double> law = laws.rows[at(model.material[at(t)])];
    for (int c = 0; c < 3; ++c) {
      const Index v = model.triangles[at(t)].v[c];
      x[c] = x_at[at(v)];
      u[c] = displaced(v, law.damping_stiffness);
    }
    law.damping_stiffness = 1;
    const AssembleMembrane<double> args{{&corners, 1},
                                        {&model.inv_rest[at(t)], 1},
                                        {&model.area[at(t)], 1},
                                        {&only, 1},
                                        {&law, 1},
                                        {x, 3},
                                        {u, 3},
                                        1,
                                        {force, 3},
                                        {block, 6},
                                        {laws.tables.data(), laws.tables.size()},
                                        model.compression.empty()
                                            ? Span<const double>{}
                                            : Span<const double>{&model.compression[at(t)], 1}};
    assemble_membrane(args, 0);
    for (int c = 0; c < 3; ++c) work -= dot(force[c], moved(model.triangles[at(t)].v[c]));
  }
  const Hinge wings{{0, 1, 2, 3}};
  for (const Index h : at_pins_.hinges) {
    Vec3<double> x[4], u[4], direction[4];
    double torque = 0, curvature = 0;
    for (int c = 0; c < 4; ++c) {
      const Index v = model.hinges[at(h)].v[c];
      x[c] = x_at[at(v)];
      u[c] = displaced(v, model.hinge_damping[at(h)]);
    }
    const double damping = 1;
    const AssembleBending<double> args{{&wings, 1},
                                       {&model.hinge_stiffness[at(h)], 1},
                                       {&model.hinge_rest_angle[at(h)], 1},
                                       {&damping, 1},
                                       {x, 4},
                                       {u, 4},
                                       1,
                                       {direction, 4},
                                       {&torque, 1},
                                       {&curvature, 1}};
    args(0);
    for (int c = 0; c < 4; ++c) work -= torque * dot(direction[c], moved(model.hinges[at(h)].v[c]));
  }
  const auto plate = store_.plate(fixed_);
  if (plate->row_offset.empty()) return work;
  for (const Index v : at_pins_.vertices) {
    Vec3<double> held{};
    for (auto e = static_cast<std::size_t>(plate->row_offset[at(v)]);
         e < static_cast<std::size_t>(plate->row_offset[at(v) + 1]); ++e) {
      const std::size_t w = at(plate->column[e]);
      held += plate->stiffness[e] * (x1[w] - x1[at(v)]) + plate->damping[e] * (v1[w] - v1[at(v)]);
    }
    work += dot(held, moved(v));
  }
  if (at_pins_.shapes.empty()) return work;
  // The gradient of what rest shapes add, along the motion.
  constexpr double share = 1e-4;
  Vectors ahead = x1, behind = x1;
  for (const Index v : at_pins_.vertices) {
    ahead[at(v)] += share * moved(v);
    behind[at(v)] -= share * moved(v);
  }
  for (const Index t : at_pins_.shapes)
    work += (shape_energy(plate->shape, at(t), ahead) - shape_energy(plate->shape, at(t), behind)) /
            (2 * share);
  return work;
}

/// Springs change first; then their ends move.
template <class T>
double ExternalWork<T>::of_springs(const Springs& springs, const AcceptedMotion<T>& motion) const {
  const Vectors &x0 = x0_, &x1 = x1_;
  const auto& [before, after] = springs;
  double work = 0;
  if (!same_ends(before, after)) {
    for (const Spring<double>& s : before) work -= energy_of(s, x0);
    for (const Spring<double>& s : after) work += energy_of(s, x0);
  } else {
    for (std::size_t k = 0; k < after.size(); ++k) {
      const Spring<double>& s = after[k];
      Spring<double> stiffer = before[k];
      stiffer.stiffness = s.stiffness;
      work += energy_of(stiffer, x0) - energy_of(before[k], x0);
      if (s.v[1] >= 0) continue;
      if (!(s.along == before[k].along)) {
        // The spring first turns about its vertex, then its end moves along it.
        const Vec3<double>& x = x0[at(s.v[0])];
        work += dot(force_of(s, x1), s.along) *
                (dot(before[k].along, x - before[k].anchor) - dot(s.along, x - s.anchor));
        continue;
      }
      work += dot(force_of(s, x1), s.anchor - before[k].anchor);
    }
  }
  for (const Spring<double>& s : after) {
    const Vec3<double> pull = force_of(s, x1) - drag_of(s, x0, x1);
    for (int end = 0; end < 2; ++end)
      if (s.v[end] >= 0 && (*motion.fixed)[at(s.v[end])] != 0)
        work -= (end == 0 ? 1 : -1) * dot(pull, x1[at(s.v[end])] - x0[at(s.v[end])]);
  }
  return work;
}

/// An impact zone conserves momentum together with its prescribed vertices, and loses kinetic
/// energy in the frame of these. So the cloth gains at most its gain of momentum times their
/// velocity. If they have several velocities, all momentum may come from the one farthest from the
/// mean. Vertices that give way have two velocities: the prescribed one and their final one. Zones
/// move nothing but the vertices of their collisions.
template <class T>
double ExternalWork<T>::of_zones(const AcceptedMotion<T>& motion) {
  std::vector<Index> held, free;
  for (const Collision& c : *motion.collisions)
    for (const Index v : c.v) ((*motion.fixed)[at(v)] != 0 ? held : free).push_back(v);
  keep_each_once(held);
  keep_each_once(free);
  std::vector<Index> met = held;
  met.insert(met.end(), free.begin(), free.end());
  met_.grow(met.size());
  upload(store_.devices()[0].compute(), met_, met);
  const Span<const Index> held_met = met_.span().subspan(0, held.size());
  const Span<const Index> free_met = met_.span().subspan(held.size(), free.size());
  Vec3<double> low{}, high{};
  const std::vector<Vec3<T>> x0 = fetch(held_met, store_.rank(0).positions.span());
  bool any = false;
  for (const Span<const Vec3<T>> end : {motion.positions_solved, motion.positions}) {
    const std::vector<Vec3<T>> x1 = fetch(held_met, end);
    for (std::size_t i = 0; i < held.size(); ++i) {
      const auto moved = vec_cast<double>(x1[i] - x0[i]);
      for (int k = 0; k < 3; ++k) {
        low[k] = any ? std::min(low[k], moved[k]) : moved[k];
        high[k] = any ? std::max(high[k], moved[k]) : moved[k];
      }
      any = true;
    }
  }
  if (length_sq(low) == 0 && length_sq(high) == 0) return 0;
  const std::vector<Vec3<T>> v_solved = fetch(free_met, motion.velocities_solved);
  const std::vector<Vec3<T>> v_end = fetch(free_met, motion.velocities);
  Vec3<double> momentum{};
  double all = 0;
  for (std::size_t i = 0; i < free.size(); ++i) {
    const Vec3<double> p =
        store_.model().mass[at(free[i])] * vec_cast<double>(v_end[i] - v_solved[i]);
    momentum += p;
    all += length(p);
  }
  return (dot(momentum, 0.5 * (low + high)) + all * length(0.5 * (high - low))) / motion.dt;
}

template class ExternalWork<float>;
template class ExternalWork<double>;

}  // namespace weft
