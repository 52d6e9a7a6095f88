#include "host/untangle/spread.hpp"

#include "weft/core/at.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace weft {
namespace {

using Point = Vec3<double>;

constexpr double obedience = 20;   ///< of points that are given a motion, over an edge's weight
constexpr double reach_least = 3;  ///< edges
constexpr double reach_most = 40;  ///< edges
constexpr int sweeps = 4;          ///< of relax()
constexpr double longest = 1.1;    ///< times the first length
constexpr double shortest = 0.5;
constexpr int iterations_max = 200;  ///< of conjugate gradients
constexpr double tolerance = 1e-3;

double product(const std::vector<Point>& a, const std::vector<Point>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += dot(a[i], b[i]);
  return sum;
}

}  // namespace

Spreader::Spreader(const IntersectingSurfaces& surfaces, const SurfaceTopology& topology)
    : surfaces_(surfaces),
      topology_(topology),
      wishes_(surfaces.points.size()),
      reach_(surfaces.points.size(), 0),
      local_(surfaces.points.size(), -1) {
  for (const Edge& e : topology.edges)
    first_length_.push_back(length(surfaces.points[at(e.v[1])] - surfaces.points[at(e.v[0])]));
}

void Spreader::wish(const Corrections& corrections, double step) {
  for (const Correction& c : corrections.list) {
    double mobility = 0;
    for (int j = 0; j < c.count; ++j)
      mobility += c.weight[j] * c.weight[j] * surfaces_.inverse_mass[at(c.point[j])];
    if (!(mobility > 0)) continue;
    const double size = length(c.displacement);
    const Point wanted = size > step ? c.displacement * (step / size) : c.displacement;
    const double reach =
        c.region < 0
            ? reach_least
            : std::clamp(
                  std::sqrt(static_cast<double>(corrections.regions[at(c.region)].points.size())),
                  reach_least, reach_most);
    for (int j = 0; j < c.count; ++j) {
      const Index v = c.point[j];
      if (surfaces_.inverse_mass[at(v)] == 0 || c.weight[j] == 0) continue;
      const double weight = std::fabs(c.weight[j]);
      Wish& w = wishes_[at(v)];
      if (w.weight == 0) active_.push_back(v);
      w.sum += wanted * (weight * c.weight[j] * surfaces_.inverse_mass[at(v)] / mobility);
      w.weight += weight;
      reach_[at(v)] = std::max(reach_[at(v)], reach);
    }
  }
}

void Spreader::surround(const Corrections& corrections) {
  std::sort(active_.begin(), active_.end());
  for (std::size_t i = 0; i < active_.size(); ++i) {
    local_[at(active_[i])] = static_cast<Index>(i);
    drag_.push_back(1 / (reach_[at(active_[i])] * reach_[at(active_[i])]));
  }
  // Ring by ring, three times as far as motion decays to a third.
  std::vector<double> rings;
  for (const Index v : active_) rings.push_back(3 * reach_[at(v)]);
  for (std::size_t i = 0; i < active_.size(); ++i) {
    if (rings[i] < 1) continue;
    const Index v = active_[i];
    for (Index k = topology_.point_first[at(v)]; k < topology_.point_first[at(v) + 1]; ++k) {
      const Index w = topology_.neighbours[at(k)];
      if (local_[at(w)] >= 0 || surfaces_.inverse_mass[at(w)] == 0) continue;
      local_[at(w)] = static_cast<Index>(active_.size());
      active_.push_back(w);
      drag_.push_back(drag_[i]);
      rings.push_back(rings[i] - 1);
    }
  }
  for (const Region& region : corrections.regions)
    for (const Index v : region.points) {
      if (surfaces_.inverse_mass[at(v)] == 0) continue;
      if (local_[at(v)] < 0) {
        local_[at(v)] = static_cast<Index>(active_.size());
        active_.push_back(v);
        drag_.push_back(0);
      }
      drag_[at(local_[at(v)])] = 0;
    }
}

std::vector<Vec3<double>> Spreader::solve() const {
  const std::size_t n = active_.size();
  std::vector<double> diagonal(n);
  std::vector<Point> x(n, Point{0, 0, 0}), r(n), p(n), z(n), q(n);
  for (std::size_t i = 0; i < n; ++i) {
    const auto v = at(active_[i]);
    const Wish& w = wishes_[v];
    diagonal[i] = drag_[i] + (w.weight > 0 ? obedience : 0) +
                  static_cast<double>(topology_.point_first[v + 1] - topology_.point_first[v]);
    r[i] = w.weight > 0 ? w.sum * (obedience / w.weight) : Point{0, 0, 0};
    p[i] = z[i] = r[i] * (1 / diagonal[i]);
  }
  double rz = product(r, z);
  const double enough = tolerance * tolerance * rz;
  for (int iteration = 0; iteration < iterations_max && rz > enough; ++iteration) {
    for (std::size_t i = 0; i < n; ++i) {
      const auto v = at(active_[i]);
      q[i] = p[i] * diagonal[i];
      for (Index k = topology_.point_first[v]; k < topology_.point_first[v + 1]; ++k) {
        const Index j = local_[at(topology_.neighbours[at(k)])];
        if (j >= 0) q[i] -= p[at(j)];
      }
    }
    const double alpha = rz / product(p, q);
    for (std::size_t i = 0; i < n; ++i) {
      x[i] += p[i] * alpha;
      r[i] -= q[i] * alpha;
      z[i] = r[i] * (1 / diagonal[i]);
    }
    const double next = product(r, z);
    for (std::size_t i = 0; i < n; ++i) p[i] = z[i] + p[i] * (next / rz);
    rz = next;
  }
  return x;
}

std::vector<Vec3<double>> Spreader::motion(const Corrections& corrections, double step) {
  wish(corrections, step);
  surround(corrections);
  const std::vector<Point> found = solve();
  std::vector<Point> result(surfaces_.points.size(), Point{0, 0, 0});
  for (std::size_t i = 0; i < active_.size(); ++i) {
    const auto v = at(active_[i]);
    const double size = length(found[i]);
    result[v] = size > step ? found[i] * (step / size) : found[i];
    wishes_[v] = {};
    reach_[v] = 0;
    local_[v] = -1;
  }
  active_.clear();
  drag_.clear();
  return result;
}

void Spreader::relax(const std::vector<unsigned char>& moved,
                     std::vector<Vec3<double>>& points) const {
  std::vector<Index> edges;
  for (std::size_t e = 0; e < topology_.edges.size(); ++e) {
    const Edge& edge = topology_.edges[e];
    if (moved[at(edge.v[0])] != 0 || moved[at(edge.v[1])] != 0)
      edges.push_back(static_cast<Index>(e));
  }
  for (int sweep = 0; sweep < sweeps; ++sweep)
    for (const Index e : edges) {
      const Edge& edge = topology_.edges[at(e)];
      const double w0 = surfaces_.inverse_mass[at(edge.v[0])];
      const double w1 = surfaces_.inverse_mass[at(edge.v[1])];
      const Point way = points[at(edge.v[1])] - points[at(edge.v[0])];
      const double now = length(way);
      const double allowed =
          std::clamp(now, shortest * first_length_[at(e)], longest * first_length_[at(e)]);
      if (allowed == now || !(now > 0) || !(w0 + w1 > 0)) continue;
      const Point change = way * ((now - allowed) / (now * (w0 + w1)));
      points[at(edge.v[0])] += change * w0;
      points[at(edge.v[1])] -= change * w1;
    }
}

double Spreader::stretch(const std::vector<Vec3<double>>& points) const {
  double sum = 0;
  for (std::size_t e = 0; e < topology_.edges.size(); ++e) {
    const Edge& edge = topology_.edges[e];
    const double now = length(points[at(edge.v[1])] - points[at(edge.v[0])]);
    const double allowed = std::clamp(now, shortest * first_length_[e], longest * first_length_[e]);
    if (now == allowed || !(first_length_[e] > 0)) continue;
    const double excess = (now - allowed) / first_length_[e];
    sum += excess * excess;
  }
  return sum;
}

}  // namespace weft
