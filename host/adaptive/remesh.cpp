#include "host/adaptive/remesh.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <numbers>
#include <optional>

#include "host/model/material_rows.hpp"
#include "weft/core/at.hpp"

namespace weft {
namespace {

/// Edges that remain after a collapse keep this distance from having to be split again.
constexpr double hysteresis = 0.1;
/// Rounds of splits, each of which halves what is too long, and of collapses.
constexpr int rounds_max = 40;
/// No operation makes a triangle thinner than this, unless those before it were.
constexpr double sliver = 0.02;
/// How far the normals of what is replaced may turn: the cosine.
constexpr double turn_min = 0.25;
/// What one operation may add to the energy or take from it, as a share of what all may together.
constexpr double single_share = 0.1;

using Change = std::vector<FreshTriangle>;

/// One remesh.
class Remesher {
 public:
  Remesher(SurfaceMesh& mesh, PinSets& pins, Clearance& clearance, const RemeshOptions& options)
      : m_(mesh),
        pins_(pins),
        clearance_(clearance),
        options_(options),
        single_(single_share * options.budget.joules),
        limited_(options.budget.laws != nullptr && has_limits(*options.budget.laws)) {
    for (std::size_t v = 0; v < mesh.sewn.size(); ++v)
      if (mesh.sewn[v] >= 0) sewn_together_[mesh.sewn[v]].push_back(static_cast<Index>(v));
    if (std::isfinite(options.budget.joules)) bending_.emplace(mesh, options.bending, single_);
  }

  RemeshCounts run() {
    flip(all_edges());
    split();
    collapse();
    flip(all_edges());
    return counts_;
  }

 private:
  std::vector<Index> all_edges() const {
    std::vector<Index> edges;
    for (Index h = 0; h < static_cast<Index>(m_.twin.size()); ++h)
      if (m_.alive(h / 3) && m_.twin[at(h)] < h) edges.push_back(h);
    return edges;
  }

  void flip(std::vector<Index> edges);
  void split();
  void collapse();

  bool flip_one(Index h);
  bool split_one(Index h);
  bool collapse_one(Index h);

  bool may_collapse(Index h) const;
  bool pins_can_spare(Index v) const;
  bool sizes_allow(Index h, const CollapseResult& plan) const;
  bool shapes_allow(const Change& fresh, const std::vector<Index>& old, double aspect_min) const;
  double thinnest(const std::vector<Index>& triangles) const;
  struct Stretched;
  double energy(const Tri& tri, const Tri& corner, Index kind) const;
  double excess_of(const Tri& tri, const Tri& corner, Index kind) const;
  bool keeps_limits(const Change& fresh, const std::vector<Index>& old) const;
  double energy_of(const Change& fresh, const std::vector<Index>& old) const;
  bool is_affordable(double cost) const;
  bool stacks(const Change& fresh, const std::vector<Index>& old) const;
  bool may_do(const Change& fresh, const std::vector<Index>& old);

  /// Momentum of the vertices, of those that may change only, before and after a change.
  Vec3<double> momentum_of(const std::vector<Index>& vertices) const;
  void give_back(const std::vector<Index>& vertices, const Vec3<double>& before);

  SurfaceMesh& m_;
  PinSets& pins_;
  Clearance& clearance_;
  const RemeshOptions& options_;
  double single_;  ///< [J] what one flip or collapse may cost
  /// Vertices by SurfaceMesh::sewn.
  std::map<Index, std::vector<Index>> sewn_together_;
  bool limited_;                        ///< some material has strain limits
  std::optional<BendingCost> bending_;  ///< none where any energy will do
  RemeshCounts counts_;
  std::vector<Index> changed_;  ///< triangles, some more than once, since split() has cleared it
  double spent_ = 0;  ///< [J] what flips and collapses have added, less what they have taken
  double split_ = 0;  ///< [J] what splits have
  std::set<std::pair<Index, Index>> refused_;  ///< edges whose split would meet something
};

double perimeter(const Vec3<double> x[3]) {
  return length(x[1] - x[0]) + length(x[2] - x[1]) + length(x[0] - x[2]);
}

double world_aspect(const std::vector<Vec3<double>>& points, const Tri& t) {
  const Vec3<double> x[3] = {points[at(t.v[0])], points[at(t.v[1])], points[at(t.v[2])]};
  return aspect(length(cross(x[1] - x[0], x[2] - x[0])) / 2, perimeter(x));
}

double material_aspect(const SurfaceMesh& m, const Tri& c) {
  const Vec2<double>* u[3];
  for (int j = 0; j < 3; ++j) u[j] = &m.material[at(c.v[j])];
  return aspect(m.material_det(c) / 2,
                length(*u[1] - *u[0]) + length(*u[2] - *u[1]) + length(*u[0] - *u[2]));
}

Vec3<double> normal_of(const std::vector<Vec3<double>>& points, const Tri& t) {
  return cross(points[at(t.v[1])] - points[at(t.v[0])], points[at(t.v[2])] - points[at(t.v[0])]);
}

/// The edge across which something joins the ends of `h` to new corners may be worth flipping.
std::vector<Index> edges_of(const SurfaceMesh& m, const std::vector<Index>& triangles) {
  std::vector<Index> edges;
  edges.reserve(3 * triangles.size());
  for (const Index t : triangles)
    if (m.alive(t))
      for (Index h = 3 * t; h < 3 * t + 3; ++h) edges.push_back(std::max(h, m.twin[at(h)]));
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

// ---- what may be done

bool Remesher::shapes_allow(const Change& fresh, const std::vector<Index>& old,
                            double aspect_min) const {
  double least_material = 1, least_world = 1, least_start = 1;
  Vec3<double> mean{0, 0, 0};
  for (const Index t : old) {
    const Tri& tri = m_.triangles[at(t)];
    least_material = std::min(least_material, material_aspect(m_, m_.corners[at(t)]));
    least_world = std::min(least_world, world_aspect(m_.positions, tri));
    least_start = std::min(least_start, world_aspect(m_.starts, tri));
    mean += normal_of(m_.positions, tri);
  }
  const double mean_length = length(mean);
  for (const auto& [tri, corner, kind] : fresh) {
    if (!(m_.material_det(corner) > 0)) return false;
    if (!(material_aspect(m_, corner) >= std::min(aspect_min, least_material))) return false;
    if (!(world_aspect(m_.positions, tri) >= std::min(sliver, least_world))) return false;
    if (!(world_aspect(m_.starts, tri) >= std::min(sliver, least_start))) return false;
    const Vec3<double> normal = normal_of(m_.positions, tri);
    if (!(dot(normal, mean) > turn_min * length(normal) * mean_length)) return false;
  }
  return true;
}

/// The least aspect of triangles, in material and world space and at the start.
double Remesher::thinnest(const std::vector<Index>& triangles) const {
  double least = 1;
  for (const Index t : triangles) {
    const Tri& tri = m_.triangles[at(t)];
    least = std::min({least, material_aspect(m_, m_.corners[at(t)]),
                      world_aspect(m_.positions, tri), world_aspect(m_.starts, tri)});
  }
  return least;
}

/// A triangle as the laws of stretching take it.
struct Remesher::Stretched {
  Vec3<double> x[3];
  Mat2<double> inv_rest;
  double area;
  Stretched(const SurfaceMesh& m, const Tri& tri, const Tri& corner)
      : x{m.positions[at(tri.v[0])], m.positions[at(tri.v[1])], m.positions[at(tri.v[2])]},
        area(m.material_det(corner) / 2) {
    const Vec2<double>& u = m.material[at(corner.v[0])];
    const Vec2<double> a = m.material[at(corner.v[1])] - u, b = m.material[at(corner.v[2])] - u;
    const double det = 2 * area;
    inv_rest = {{b[1] / det, -b[0] / det, -a[1] / det, a[0] / det}};
  }
};

/// Stretching energy of a triangle. [J]
double Remesher::energy(const Tri& tri, const Tri& corner, Index kind) const {
  const Stretched t(m_, tri, corner);
  return stretching_energy(*options_.budget.laws, m_.kinds[at(kind)].material, t.x, t.inv_rest,
                           t.area);
}

/// By how much a triangle exceeds the strain limits of its material, see limit_excess(). [1]
double Remesher::excess_of(const Tri& tri, const Tri& corner, Index kind) const {
  const Stretched t(m_, tri, corner);
  return limit_excess(*options_.budget.laws, m_.kinds[at(kind)].material, t.x, t.inv_rest);
}

/// Whether no new triangle exceeds its limits by more than those it replaces.
bool Remesher::keeps_limits(const Change& fresh, const std::vector<Index>& old) const {
  if (!limited_) return true;
  double before = 0;
  for (const Index t : old)
    before = std::max(before, excess_of(m_.triangles[at(t)], m_.corners[at(t)], m_.kind[at(t)]));
  return std::all_of(fresh.begin(), fresh.end(), [&](const FreshTriangle& f) {
    return excess_of(f.tri, f.corner, f.kind) <= before;
  });
}

/// What a change costs. [J]
double Remesher::energy_of(const Change& fresh, const std::vector<Index>& old) const {
  double change = 0;
  for (const Index t : old)
    change -= energy(m_.triangles[at(t)], m_.corners[at(t)], m_.kind[at(t)]);
  for (const auto& [tri, corner, kind] : fresh) change += energy(tri, corner, kind);
  return change;
}

/// Whether one change may cost so much after those before. What takes energy away may take as much
/// as splits have added.
bool Remesher::is_affordable(double cost) const {
  const double sum = spent_ + cost;
  if (cost > 0) return cost <= single_ && sum <= options_.budget.joules;
  return sum + std::max(0.0, split_) >= -options_.budget.joules;
}

/// The places of a triangle's corners once all seams are welded, in ascending order; the first is
/// -1 if not all of them are on seams.
std::array<Index, 3> sewn_places(const SurfaceMesh& m, const Tri& tri) {
  std::array<Index, 3> places{-1, -1, -1};
  for (std::size_t j = 0; j < 3; ++j)
    if (at(tri.v[j]) < m.sewn.size()) places[j] = m.sewn[at(tri.v[j])];
  std::sort(places.begin(), places.end());
  return places;
}

/// Whether a new triangle would lie on another one once all seams are welded, as can happen in the
/// corner of two panels that are sewn on both sides of it.
bool Remesher::stacks(const Change& fresh, const std::vector<Index>& old) const {
  for (const FreshTriangle& f : fresh) {
    const std::array<Index, 3> places = sewn_places(m_, f.tri);
    if (places[0] < 0) continue;
    for (const Index v : sewn_together_.at(places[0]))
      for (const Index out : m_.star(v))
        if (std::find(old.begin(), old.end(), out / 3) == old.end() &&
            sewn_places(m_, m_.triangles[at(out / 3)]) == places)
          return true;
  }
  return false;
}

/// Whether a change is cheap enough and meets nothing; counts what it costs, or that it is refused.
bool Remesher::may_do(const Change& fresh, const std::vector<Index>& old) {
  const double stretch = bending_ ? energy_of(fresh, old) : 0;
  std::vector<Tri> triangles;
  for (const FreshTriangle& f : fresh) triangles.push_back(f.tri);
  if (std::abs(stretch) > single_ || !is_affordable(stretch) || !keeps_limits(fresh, old) ||
      stacks(fresh, old) || !clearance_.is_clear(triangles, old, true)) {
    ++counts_.refused;
    return false;
  }
  const double cost = stretch + (bending_ ? bending_->change(fresh, old) : 0);
  if (!is_affordable(cost)) {
    ++counts_.refused;
    return false;
  }
  spent_ += cost;
  return true;
}

// ---- momentum

Vec3<double> Remesher::momentum_of(const std::vector<Index>& vertices) const {
  Vec3<double> sum{0, 0, 0};
  for (const Index v : vertices)
    if (m_.leaving[at(v)] >= 0) sum += m_.mass[at(v)] * m_.velocities[at(v)];
  return sum;
}

/// What the new masses have made of the momentum is shared out to those that are free.
void Remesher::give_back(const std::vector<Index>& vertices, const Vec3<double>& before) {
  double mass = 0;
  for (const Index v : vertices)
    if (m_.leaving[at(v)] >= 0 && m_.heavy[at(v)] == 0) mass += m_.mass[at(v)];
  if (!(mass > 0)) return;
  const Vec3<double> change = (1 / mass) * (before - momentum_of(vertices));
  for (const Index v : vertices)
    if (m_.leaving[at(v)] >= 0 && m_.heavy[at(v)] == 0) m_.velocities[at(v)] += change;
}

// ---- flips

bool Remesher::flip_one(Index h) {
  const Index g = m_.twin[at(h)];
  const Index t = h / 3, s = g / 3;
  const Index a = m_.from(h), b = m_.to(h), c = m_.apex(h), d = m_.apex(g);
  const Index ua = m_.corner_from(h), ub = m_.corner_to(h);
  const Index uc = m_.corners[at(t)].v[(h + 2) % 3], ud = m_.corners[at(s)].v[(g + 2) % 3];
  // The new edge must not be there already.
  for (const Index out : m_.star(c))
    if (m_.to(out) == d || m_.apex(out) == d) return false;
  const Index kind = m_.kind[at(t)];
  const Change fresh{{{{a, d, c}}, {{ua, ud, uc}}, kind}, {{{d, b, c}}, {{ud, ub, uc}}, kind}};
  const double floor = options_.settings[at(m_.kinds[at(kind)].cloth)].aspect_min;
  if (!shapes_allow(fresh, {t, s}, std::max(sliver, floor)) || !may_do(fresh, {t, s})) return false;
  const std::vector<Index> around{a, b, c, d};
  const Vec3<double> before = momentum_of(around);
  flip_edge(m_, h);
  if (bending_) bending_->forget({t, s});
  give_back(around, before);
  clearance_.update({t, s});
  changed_.insert(changed_.end(), {t, s});
  ++counts_.flips;
  return true;
}

void Remesher::flip(std::vector<Index> edges) {
  // Each flip is closer to Delaunay; the bound is for metrics in which that goes round.
  std::size_t left = 4 * edges.size() + 64;
  for (int round = 0; round < rounds_max && !edges.empty(); ++round) {
    std::vector<Index> touched;
    for (const Index h : edges) {
      if (!m_.alive(h / 3) || !should_flip(m_, h, options_.flip_threshold) || left == 0) continue;
      const Index across = m_.twin[at(h)] / 3;
      --left;
      if (!flip_one(h)) continue;
      touched.push_back(h / 3);
      touched.push_back(across);
    }
    edges = edges_of(m_, touched);
  }
}

// ---- splits

bool Remesher::split_one(Index h) {
  const Index a = m_.from(h), b = m_.to(h);
  std::vector<Index> touched{h / 3};
  if (m_.twin[at(h)] >= 0) touched.push_back(m_.twin[at(h)] / 3);
  const double least = std::min(sliver, thinnest(touched));
  const double slight = bending_ ? bending_->hinges_at(touched) : 0;
  const bool bends = bending_ && !bending_->is_slight(slight);
  const double before = bends ? bending_->around(touched) : 0;
  const Index v = split_edge(m_, h, options_.single, touched);
  if (bending_) bending_->forget(touched);
  std::vector<Tri> triangles;
  for (const Index t : touched) triangles.push_back(m_.triangles[at(t)]);
  // A split along the surface stretches nothing.
  const double cost = bends ? bending_->around(touched) - before : slight;
  if (thinnest(touched) < least || cost > options_.budget.joules ||
      split_ + cost > options_.budget.splits || !clearance_.is_clear(triangles, touched, false)) {
    undo_split(m_, h, v, touched);
    if (bending_) bending_->forget(touched);
    refused_.insert({std::min(a, b), std::max(a, b)});
    ++counts_.refused;
    return false;
  }
  split_ += cost;
  changed_.insert(changed_.end(), touched.begin(), touched.end());
  m_.hold[at(v)] = pins_.common(m_.hold[at(a)], m_.hold[at(b)]);
  m_.heavy[at(v)] = m_.hold[at(v)] != 0 ? 1 : 0;
  // A clamp's slope counts where the cost above took a free point.
  if (bending_ && m_.hold[at(v)] != 0) bending_->forget(touched);
  clearance_.update(touched);
  ++counts_.splits;
  flip(edges_of(m_, touched));
  return true;
}

void Remesher::split() {
  struct Long {
    double size;
    Index h, a, b;
  };
  // Where nothing has changed since the round before, no edge is too long that was not.
  std::vector<Index> edges = all_edges();
  for (int round = 0; round < rounds_max; ++round) {
    std::vector<Long> list;
    for (const Index h : edges) {
      const double size = edge_size(m_, h);
      if (!(size > 1) || m_.locked[at(h)] != 0) continue;
      const Index a = m_.from(h), b = m_.to(h);
      if (refused_.count({std::min(a, b), std::max(a, b)}) == 0) list.push_back({size, h, a, b});
    }
    if (list.empty()) return;
    std::sort(list.begin(), list.end(), [](const Long& p, const Long& q) {
      return p.size != q.size ? p.size > q.size : p.h < q.h;
    });
    changed_.clear();
    for (const Long& edge : list)
      // A flip nearby may have taken the place of this one.
      if (m_.alive(edge.h / 3) && m_.from(edge.h) == edge.a && m_.to(edge.h) == edge.b)
        split_one(edge.h);
    std::sort(changed_.begin(), changed_.end());
    changed_.erase(std::unique(changed_.begin(), changed_.end()), changed_.end());
    edges = edges_of(m_, changed_);
  }
}

// ---- collapses

bool Remesher::sizes_allow(Index h, const CollapseResult& plan) const {
  const Index b = m_.to(h);
  for (const Tri& corner : plan.corners)
    for (int j = 0; j < 3; ++j)
      if (edge_size(m_, corner.v[j], corner.v[(j + 1) % 3]) > 1 - hysteresis) {
        // Edges that do not lead to the end stay as they are, however long.
        const auto k = static_cast<std::size_t>(&corner - plan.corners.data());
        const Tri& tri = plan.triangles[k];
        if (tri.v[j] == b || tri.v[(j + 1) % 3] == b) return false;
      }
  return true;
}

/// Whether the edges of a collapse may be short enough, as far as can be said without planning it:
/// most edges are refused here.
bool Remesher::may_collapse(Index h) const {
  const Index a = m_.from(h);
  if (m_.kept[at(a)] == always_kept) return false;
  const Index end = m_.corner_to(h);
  const Index own = m_.corner_from(h);
  Index s = h;
  do {
    // Beyond a seam the corners are others, and the plan has the last word.
    if (m_.corner_from(s) != own) return true;
    if (m_.corner_to(s) != end && edge_size(m_, end, m_.corner_to(s)) > 1 - hysteresis)
      return false;
    s = m_.twin[at(SurfaceMesh::previous(s))];
  } while (s >= 0 && s != h);
  return true;
}

/// Whether the pins of a vertex hold an edge without it: a pin of one or two vertices holds points
/// instead, see remesh_scene().
bool Remesher::pins_can_spare(Index v) const {
  for (const Index pin : pins_.pins(m_.hold[at(v)])) {
    int others = 0;
    for (std::size_t u = 0; u < m_.hold.size() && others < 3; ++u) {
      const std::vector<Index>& pins = pins_.pins(m_.hold[u]);
      if (m_.leaving[u] >= 0 && u != at(v) && std::binary_search(pins.begin(), pins.end(), pin))
        ++others;
    }
    if (others < 3) return false;
  }
  return true;
}

bool Remesher::collapse_one(Index h) {
  CollapseResult plan;
  if (!may_collapse(h) || !plan_collapse(m_, h, plan) || !sizes_allow(h, plan)) return false;
  if (!pins_can_spare(m_.from(h))) return false;
  std::vector<Index> old = plan.gone;
  old.insert(old.end(), plan.changed.begin(), plan.changed.end());
  const double floor = options_.settings[at(m_.kinds[at(m_.kind[at(old[0])])].cloth)].aspect_min;
  Change fresh;
  for (std::size_t k = 0; k < plan.changed.size(); ++k)
    fresh.push_back({plan.triangles[k], plan.corners[k], m_.kind[at(plan.changed[k])]});
  if (!shapes_allow(fresh, old, std::max(sliver, floor)) || !may_do(fresh, old)) return false;
  std::vector<Index> around;
  for (const Index t : old)
    for (const Index v : m_.triangles[at(t)].v) around.push_back(v);
  std::sort(around.begin(), around.end());
  around.erase(std::unique(around.begin(), around.end()), around.end());
  const Vec3<double> before = momentum_of(around);
  collapse_edge(m_, h, plan);
  if (bending_) bending_->forget(old);
  give_back(around, before);
  clearance_.update(old);
  ++counts_.collapses;
  return true;
}

void Remesher::collapse() {
  std::vector<Index> edges = all_edges();
  struct Short {
    double size;
    Index h, a, b;
  };
  for (int round = 0; round < rounds_max && !edges.empty(); ++round) {
    std::vector<Short> list;
    for (const Index h : edges) {
      const double size = edge_size(m_, h);
      if (size <= 1 - hysteresis) list.push_back({size, h, m_.from(h), m_.to(h)});
    }
    std::sort(list.begin(), list.end(), [](const Short& p, const Short& q) {
      return p.size != q.size ? p.size < q.size : p.h < q.h;
    });
    std::vector<Index> touched;
    for (const Short& edge : list) {
      Index h = edge.h;
      if (!m_.alive(h / 3) || m_.from(h) != edge.a || m_.to(h) != edge.b) continue;
      Index end = edge.b;
      if (!collapse_one(h)) {
        h = m_.twin[at(h)];
        end = edge.a;
        if (h < 0 || !collapse_one(h)) continue;
      }
      for (const Index out : m_.star(end)) touched.push_back(out / 3);
    }
    std::sort(touched.begin(), touched.end());
    touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
    edges = edges_of(m_, touched);
    flip(edges);
    edges = edges_of(m_, touched);
  }
}

}  // namespace

Index PinSets::number(const std::vector<Index>& pins) {
  const auto [place, fresh] = numbers_.try_emplace(pins, static_cast<Index>(sets_.size()));
  if (fresh) sets_.push_back(pins);
  return place->second;
}

Index PinSets::common(Index a, Index b) {
  if (a == b || a == 0 || b == 0) return a == b ? a : 0;
  std::vector<Index> both;
  std::set_intersection(pins(a).begin(), pins(a).end(), pins(b).begin(), pins(b).end(),
                        std::back_inserter(both));
  return number(both);
}

double aspect(double area, double perimeter) {
  return perimeter > 0 ? 12 * std::numbers::sqrt3 * area / (perimeter * perimeter) : 0;
}

bool should_flip(const SurfaceMesh& m, Index h, double threshold) {
  if (m.is_border(h)) return false;
  const Index g = m.twin[at(h)];
  const Index corner[4] = {m.corner_from(h), m.corners[at(h / 3)].v[(h + 2) % 3], m.corner_to(h),
                           m.corners[at(g / 3)].v[(g + 2) % 3]};
  const Vec2<double> x = m.material[at(corner[0])], w = m.material[at(corner[1])];
  const Vec2<double> z = m.material[at(corner[2])], y = m.material[at(corner[3])];
  Mat2<double> mean{};
  for (const Index c : corner) mean += 0.25 * m.metric[at(c)];
  const auto wedge = [](const Vec2<double>& a, const Vec2<double>& b) {
    return a[0] * b[1] - a[1] * b[0];
  };
  const double right = wedge(z - y, x - y);
  const double left = wedge(x - w, z - w);
  const double value = right * dot(x - w, mean * (z - w)) + dot(z - y, mean * (x - y)) * left;
  return value < -threshold * (right + left);
}

RemeshCounts remesh(SurfaceMesh& mesh, PinSets& pins, Clearance& clearance,
                    const RemeshOptions& options) {
  return Remesher(mesh, pins, clearance, options).run();
}

}  // namespace weft
