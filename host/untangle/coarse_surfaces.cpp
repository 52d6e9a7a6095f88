#include "host/untangle/coarse_surfaces.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "host/geometry/tri_has.hpp"
#include "weft/core/at.hpp"

namespace weft {
namespace {

using Point = Vec3<double>;

constexpr int passes_max = 40;
constexpr double pass_least = 0.01;       ///< of the vertices that are left; fewer end the passes
constexpr double shape_least = 0.2;       ///< of a new triangle; 1: equilateral
constexpr double turn_cosine = 0.7;       ///< of a triangle by a collapse, at least
constexpr double straight_cosine = -0.9;  ///< between the edges of a border at a vertex, at most

}  // namespace

/// The passes of one coarsening.
class CoarseSurfaces::Decimation {
 public:
  Decimation(const IntersectingSurfaces& fine, CoarseSurfaces& result)
      : fine_(fine),
        result_(result),
        triangles_(fine.triangles.begin(), fine.triangles.begin() + fine.cloth_triangle_count),
        left_(fine.cloth_triangle_count),
        alive_(triangles_.size(), 1),
        around_(fine.points.size()),
        mass_(fine.points.size(), 0),
        gone_(fine.points.size(), 0) {
    for (std::size_t t = 0; t < triangles_.size(); ++t)
      for (const Index v : triangles_[t].v) around_[at(v)].push_back(static_cast<Index>(t));
    for (std::size_t v = 0; v < mass_.size(); ++v)
      if (fine.inverse_mass[v] > 0) mass_[v] = 1 / fine.inverse_mass[v];
  }

  void run(Index wanted) {
    for (int pass = 0; pass < passes_max && left_ > wanted; ++pass) {
      const std::vector<Index> order = smallest_first();
      std::vector<unsigned char> locked(fine_.points.size(), 0);
      std::size_t removed = 0;
      for (const Index v : order) {
        if (left_ <= wanted) break;
        if (locked[at(v)] != 0 || !remove(v)) continue;
        ++removed;
        for (const Index w : ring_) locked[at(w)] = 1;
      }
      if (static_cast<double>(removed) < pass_least * static_cast<double>(order.size())) break;
    }
    finish();
  }

 private:
  Point place(Index v) const { return fine_.points[at(v)]; }

  /// Twice the area of a triangle, along its normal.
  Point normal(const Tri& t) const {
    return cross(place(t.v[1]) - place(t.v[0]), place(t.v[2]) - place(t.v[0]));
  }

  std::vector<Index> smallest_first() const {
    std::vector<double> size(fine_.points.size(), 0);
    for (std::size_t t = 0; t < triangles_.size(); ++t)
      if (alive_[t] != 0)
        for (const Index v : triangles_[t].v) size[at(v)] += length(normal(triangles_[t]));
    std::vector<Index> order;
    for (std::size_t v = 0; v < around_.size(); ++v)
      if (gone_[v] == 0 && !around_[v].empty()) order.push_back(static_cast<Index>(v));
    std::sort(order.begin(), order.end(), [&](Index a, Index b) {
      return size[at(a)] != size[at(b)] ? size[at(a)] < size[at(b)] : a < b;
    });
    return order;
  }

  /// Puts the neighbours of a vertex into ring_, one after the other around it.
  /// @return false unless its triangles are one fan; `closed` if this goes all around
  bool walk(Index v, bool& closed) {
    sides_.clear();
    for (const Index t : around_[at(v)]) {
      const Tri& tri = triangles_[at(t)];
      const std::size_t j = tri.v[0] == v ? 0 : (tri.v[1] == v ? 1 : 2);
      sides_.push_back({tri.v[(j + 1) % 3], tri.v[(j + 2) % 3]});
    }
    // An end of the fan, if there is one.
    Index start = sides_[0][0];
    int ends = 0;
    for (const auto& side : sides_)
      for (const Index w : side) {
        int count = 0;
        for (const auto& other : sides_) count += (other[0] == w) + (other[1] == w);
        if (count > 2) return false;
        if (count != 1) continue;
        if (++ends == 1) start = w;
      }
    if (ends != 0 && ends != 2) return false;
    closed = ends == 0;
    ring_.assign(1, start);
    std::vector<unsigned char> used(sides_.size(), 0);
    for (std::size_t step = 0; step < sides_.size(); ++step) {
      bool found = false;
      for (std::size_t i = 0; i < sides_.size() && !found; ++i) {
        if (used[i] != 0 || (sides_[i][0] != ring_.back() && sides_[i][1] != ring_.back()))
          continue;
        used[i] = 1;
        found = true;
        ring_.push_back(sides_[i][0] == ring_.back() ? sides_[i][1] : sides_[i][0]);
      }
      if (!found) return false;
    }
    if (closed) {
      if (ring_.back() != ring_.front()) return false;
      ring_.pop_back();
    }
    return ring_.size() >= 3 || !closed;
  }

  /// Mean value coordinates of a vertex that its ring goes all around, or its share in the border.
  /// @return false where they are not defined
  bool weigh(Index v, bool closed) {
    const std::size_t n = ring_.size();
    weights_.assign(n, 0);
    std::vector<Point> way;
    std::vector<double> far;
    for (const Index w : ring_) {
      way.push_back(place(w) - place(v));
      far.push_back(length(way.back()));
      if (!(far.back() > 0)) return false;
    }
    if (!closed) {
      const double both = far.front() + far.back();
      if (dot(way.front(), way.back()) > straight_cosine * far.front() * far.back()) return false;
      weights_.front() = far.back() / both;
      weights_.back() = far.front() / both;
      return true;
    }
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t j = (i + 1) % n;
      const double product = far[i] * far[j];
      const double half =
          length(cross(way[i], way[j])) / std::max(product + dot(way[i], way[j]), 1e-6 * product);
      weights_[i] += half / far[i];
      weights_[j] += half / far[j];
    }
    double sum = 0;
    for (const double w : weights_) sum += w;
    if (!(sum > 0)) return false;
    for (double& w : weights_) w /= sum;
    return true;
  }

  bool neighbours(Index a, Index b) const {
    return std::any_of(around_[at(a)].begin(), around_[at(a)].end(),
                       [&](Index t) { return has(triangles_[at(t)], b); });
  }

  /// Whether the mesh stays one of the same kind if v becomes ring_[i].
  bool may_become(std::size_t i, bool closed) const {
    const std::size_t n = ring_.size();
    for (std::size_t j = 0; j < n; ++j) {
      const std::size_t gap = i > j ? i - j : j - i;
      const bool beside = gap <= 1 || (closed && gap == n - 1);
      if (!beside && neighbours(ring_[i], ring_[j])) return false;
    }
    return true;
  }

  /// Least shape of the triangles that a collapse of v into w makes; 0 if one turns too far.
  double shape_after(Index v, Index w) const {
    double least = 1;
    for (const Index t : around_[at(v)]) {
      Tri tri = triangles_[at(t)];
      if (has(tri, w)) continue;
      const Point before = normal(tri);
      for (Index& u : tri.v)
        if (u == v) u = w;
      const Point after = normal(tri);
      const double size = length(after);
      if (!(dot(before, after) >= turn_cosine * length(before) * size)) return 0;
      double sides = 0;
      for (int j = 0; j < 3; ++j) sides += length_sq(place(tri.v[(j + 1) % 3]) - place(tri.v[j]));
      least = std::min(least, 2 * std::sqrt(3.0) * size / sides);
    }
    return least;
  }

  bool remove(Index v) {
    bool closed = false;
    if (around_[at(v)].empty() || !walk(v, closed) || !weigh(v, closed)) return false;
    const bool moves = fine_.inverse_mass[at(v)] > 0;
    for (std::size_t i = 0; i < ring_.size() && !moves; ++i)
      if (weights_[i] > 0 && fine_.inverse_mass[at(ring_[i])] > 0) return false;
    Index into = -1;
    double best = shape_least;
    for (std::size_t i = 0; i < ring_.size(); i += closed ? 1 : ring_.size() - 1) {
      const double shape = shape_after(v, ring_[i]);
      if (shape <= best || !may_become(i, closed)) continue;
      best = shape;
      into = ring_[i];
    }
    if (into < 0) return false;
    collapse(v, into);
    Removed removed{v, result_.shares_.size(), 0};
    for (std::size_t i = 0; i < ring_.size(); ++i) {
      if (!(weights_[i] > 0)) continue;
      result_.shares_.push_back({ring_[i], weights_[i]});
      mass_[at(ring_[i])] += weights_[i] * mass_[at(v)];
    }
    removed.last = result_.shares_.size();
    result_.removed_.push_back(removed);
    gone_[at(v)] = 1;
    return true;
  }

  void collapse(Index v, Index into) {
    for (const Index t : around_[at(v)]) {
      Tri& tri = triangles_[at(t)];
      if (has(tri, into)) {
        --left_;
        alive_[at(t)] = 0;
        for (const Index u : tri.v)
          if (u != v) std::erase(around_[at(u)], t);
        continue;
      }
      for (Index& u : tri.v)
        if (u == v) u = into;
      around_[at(into)].push_back(t);
    }
    around_[at(v)].clear();
  }

  /// Fills in the coarse surfaces.
  void finish() {
    IntersectingSurfaces& c = result_.coarse_;
    std::vector<Index> number(fine_.points.size(), -1);
    for (std::size_t v = 0; v < fine_.points.size(); ++v) {
      if (gone_[v] != 0) continue;
      number[v] = static_cast<Index>(c.points.size());
      result_.kept_.push_back(static_cast<Index>(v));
      c.points.push_back(fine_.points[v]);
      c.inverse_mass.push_back(fine_.inverse_mass[v] > 0 ? 1 / mass_[v] : 0);
    }
    const auto take = [&](const Tri& t, Index mesh) {
      c.triangles.push_back({{number[at(t.v[0])], number[at(t.v[1])], number[at(t.v[2])]}});
      c.mesh.push_back(mesh);
    };
    for (std::size_t t = 0; t < triangles_.size(); ++t)
      if (alive_[t] != 0) take(triangles_[t], fine_.mesh[t]);
    c.cloth_triangle_count = static_cast<Index>(c.triangles.size());
    for (std::size_t t = triangles_.size(); t < fine_.triangles.size(); ++t)
      take(fine_.triangles[t], fine_.mesh[t]);
    c.solid = fine_.solid;
    c.self = fine_.self;
    result_.start_ = c.points;
  }

  const IntersectingSurfaces& fine_;
  CoarseSurfaces& result_;
  std::vector<Tri> triangles_;  ///< of cloth
  Index left_;                  ///< alive ones
  std::vector<unsigned char> alive_;
  std::vector<std::vector<Index>> around_;  ///< [points] the cloth's triangles with that corner
  std::vector<double> mass_;
  std::vector<unsigned char> gone_;
  std::vector<std::array<Index, 2>> sides_;  ///< opposite to the vertex that is looked at
  std::vector<Index> ring_;
  std::vector<double> weights_;  ///< [ring]
};

CoarseSurfaces::CoarseSurfaces(const IntersectingSurfaces& fine, Index wanted) {
  Decimation(fine, *this).run(wanted);
}

std::vector<unsigned char> CoarseSurfaces::marked(std::vector<unsigned char> fine) const {
  for (const Removed& r : removed_)
    if (fine[at(r.point)] != 0)
      for (std::size_t i = r.first; i < r.last; ++i) fine[at(shares_[i].point)] = 1;
  std::vector<unsigned char> coarse;
  for (const Index v : kept_) coarse.push_back(fine[at(v)]);
  return coarse;
}

void CoarseSurfaces::carry_over(std::vector<Vec3<double>>& points) const {
  std::vector<Point> motion(points.size(), Point{0, 0, 0});
  for (std::size_t i = 0; i < kept_.size(); ++i)
    motion[at(kept_[i])] = coarse_.points[i] - start_[i];
  for (std::size_t i = removed_.size(); i-- > 0;)
    for (std::size_t k = removed_[i].first; k < removed_[i].last; ++k)
      motion[at(removed_[i].point)] += motion[at(shares_[k].point)] * shares_[k].weight;
  for (std::size_t v = 0; v < points.size(); ++v)
    if (!(motion[v] == Point{0, 0, 0})) points[v] += motion[v];
}

}  // namespace weft
