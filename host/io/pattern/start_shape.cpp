#include "host/io/pattern/start_shape.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <utility>

#include "host/geometry/aabb.hpp"
#include "host/input/quantity.hpp"
#include "host/io/pattern/arm_clearance.hpp"
#include "host/io/pattern/body_guard.hpp"
#include "host/io/pattern/joined_numbers.hpp"
#include "weft/core/at.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

/// [m] Over which cloth follows its seams. With half of it, edges start longer, which makes the
/// first step of a simulation up to three times as slow.
constexpr double seam_distance = 0.15;
constexpr double sweeps_least = 20;
constexpr double sweeps_most = 300;
/// [m] Around triangles that begin within the body nothing moves: the shape there tells what came
/// from where, and is lost once cloth around it is drawn tight.
constexpr double held_distance = 0.05;
/// [m] From the body, of cloth that is outside of it: what just misses it in double precision would
/// meet it in single.
constexpr double tight_clearance = 1e-5;
/// [m] Steps are shorter than limbs are thick.
constexpr double longest_step = 0.01;

/// An edge of the sewn garment.
struct Thread {
  std::array<Index, 2> ends;
  double rest;  ///< [m] at most: edges of different lengths may become one
};

double rest_length(const Mesh& mesh, Index a, Index b) {
  return length(mesh.material[at(a)] - mesh.material[at(b)]);
}

/// The lowest of the vertices that become one.
std::vector<Index> sewn_vertices(const Garment& garment) {
  JoinedNumbers joined(garment.mesh.positions.size());
  for (const GarmentSeam& seam : garment.seams)
    for (const auto& [a, b] : seam.pairs) joined.join(at(a), at(b));
  std::vector<Index> same;
  for (std::size_t v = 0; v < garment.mesh.positions.size(); ++v)
    same.push_back(static_cast<Index>(joined.find(v)));
  return same;
}

std::vector<Thread> sewn_edges(const Mesh& mesh, const std::vector<Index>& same) {
  std::map<std::array<Index, 2>, double> lengths;
  for (const Tri& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) {
      const Index a = t.v[k], b = t.v[(k + 1) % 3];
      const auto [low, high] = std::minmax({same[at(a)], same[at(b)]});
      double& rest = lengths[{low, high}];
      rest = std::max(rest, rest_length(mesh, a, b));
    }
  std::vector<Thread> threads;
  for (const auto& [ends, rest] : lengths)
    if (ends[0] != ends[1]) threads.push_back({ends, rest});
  return threads;
}

/// Takes all edges nearer to their lengths at rest, one after the other.
void contract(const std::vector<Thread>& threads, std::vector<Vec3<double>>& x) {
  for (const Thread& thread : threads) {
    Vec3<double>&a = x[at(thread.ends[0])], &b = x[at(thread.ends[1])];
    const Vec3<double> along = b - a;
    const double now = length(along);
    if (!(now > 0)) continue;
    // Compressed cloth would rather fold, but a fold is hard to undo.
    const double share = now > thread.rest ? 0.5 : 0.25;
    const Vec3<double> step = along * (share * (now - thread.rest) / now);
    a += step;
    b -= step;
  }
}

/// Adds the neighbours of marked vertices, over and over.
std::vector<unsigned char> widened(std::vector<unsigned char> marked,
                                   const std::vector<Thread>& threads, int rounds) {
  for (int round = 0; round < rounds; ++round) {
    const std::vector<unsigned char> last = marked;
    for (const auto& [ends, rest] : threads)
      if (last[at(ends[0])] != 0 || last[at(ends[1])] != 0)
        marked[at(ends[0])] = marked[at(ends[1])] = 1;
  }
  return marked;
}

/// Positions and triangles of both.
Mesh joined(const Mesh& a, const Mesh& b) {
  Mesh both;
  both.positions = a.positions;
  both.triangles = a.triangles;
  const auto first = static_cast<Index>(a.positions.size());
  both.positions.insert(both.positions.end(), b.positions.begin(), b.positions.end());
  for (const Tri& t : b.triangles)
    both.triangles.push_back({{t.v[0] + first, t.v[1] + first, t.v[2] + first}});
  return both;
}

/// Sweeps that a relaxation needs to reach all vertices within `seam_distance`: it advances like
/// diffusion, over n edges in n^2 sweeps.
int sweep_count(double edge) {
  const double spread = seam_distance * seam_distance / (edge * edge);
  return static_cast<int>(std::lround(std::clamp(spread, sweeps_least, sweeps_most)));
}

/// [vertices] [m] Where sewn vertices meet: their mean; where others are.
std::vector<Vec3<double>> meeting_places(const std::vector<Vec3<double>>& x,
                                         const std::vector<Index>& same) {
  std::vector<Vec3<double>> sum(x.size(), Vec3<double>{0, 0, 0});
  std::vector<int> count(x.size(), 0);
  for (std::size_t v = 0; v < x.size(); ++v) {
    sum[at(same[v])] += x[v];
    ++count[at(same[v])];
  }
  std::vector<Vec3<double>> met = x;
  for (std::size_t v = 0; v < x.size(); ++v)
    if (count[at(same[v])] > 1) met[v] = sum[at(same[v])] * (1.0 / count[at(same[v])]);
  return met;
}

/// Moves seams to where they meet, and lets the cloth of each panel follow as far as they move in
/// its own plane. Where panels overlap until they are sewn, as those of trousers do at the crotch,
/// cloth would else be left on the wrong side of a seam.
void sew_in_plane(Garment& garment, const std::vector<Vec3<double>>& met, int sweeps) {
  std::vector<Vec3<double>>& x = garment.mesh.positions;
  for (const GarmentPanel& panel : garment.panels) {
    const Index first = panel.first_vertex;
    const auto n = at(panel.vertex_count);
    Vec3<double> normal{0, 0, 0};
    std::vector<std::vector<std::size_t>> neighbours(n);
    for (Index t = 0; t < panel.triangle_count; ++t) {
      const auto& v = garment.mesh.triangles[at(panel.first_triangle + t)].v;
      normal += cross(x[at(v[1])] - x[at(v[0])], x[at(v[2])] - x[at(v[0])]);
      for (int k = 0; k < 3; ++k)
        neighbours[at(v[k] - first)].push_back(at(v[(k + 1) % 3] - first));
    }
    const double size = length(normal);
    if (size > 0) normal *= 1 / size;
    std::vector<Vec3<double>> moved(n, Vec3<double>{0, 0, 0});
    std::vector<unsigned char> sewn(n, 0);
    for (std::size_t v = 0; v < n; ++v) {
      const Vec3<double> d = met[at(first) + v] - x[at(first) + v];
      sewn[v] = length_sq(d) > 0 ? 1 : 0;
      moved[v] = d - normal * dot(d, normal);
    }
    for (int sweep = 0; sweep < sweeps; ++sweep) {
      const std::vector<Vec3<double>> last = moved;
      for (std::size_t v = 0; v < n; ++v) {
        if (sewn[v] != 0) continue;
        Vec3<double> sum{0, 0, 0};
        for (const std::size_t w : neighbours[v]) sum += last[w];
        moved[v] =
            sum * (1.0 / static_cast<double>(std::max<std::size_t>(neighbours[v].size(), 1)));
      }
    }
    for (std::size_t v = 0; v < n; ++v)
      x[at(first) + v] = sewn[v] != 0 ? met[at(first) + v] : x[at(first) + v] + moved[v];
  }
}

/// Triangles of a sewn garment, by the vertices that stand for those sewn to them.
std::vector<Tri> sewn_triangles(std::vector<Tri> triangles, const std::vector<Index>& same) {
  for (Tri& t : triangles)
    for (Index& v : t.v) v = same[at(v)];
  return triangles;
}

/// Contracts a sewn garment outside of surfaces; what begins within them stays.
void contract_outside(Garment& garment, const std::vector<Index>& same, std::vector<Tri> cloth,
                      double edge, const Mesh& within, double clearance) {
  std::vector<Vec3<double>>& x = garment.mesh.positions;
  BodyGuard guard(within, std::move(cloth), x, clearance);
  std::vector<Thread> threads = sewn_edges(garment.mesh, same);
  const std::vector<unsigned char> held = widened(
      guard.vertices_within(), threads, static_cast<int>(std::lround(held_distance / edge)));
  std::vector<Vec3<double>> before;
  for (int sweep = 0; sweep < sweep_count(edge); ++sweep) {
    before = x;
    contract(threads, x);
    // Back and forth, so that no direction is preferred.
    std::reverse(threads.begin(), threads.end());
    for (std::size_t v = 0; v < x.size(); ++v) {
      if (held[v] != 0) x[v] = before[v];
      const double step = length(x[v] - before[v]);
      if (step > longest_step) x[v] = before[v] + (x[v] - before[v]) * (longest_step / step);
    }
    guard.guard(before, x);
  }
  for (std::size_t v = 0; v < x.size(); ++v) x[v] = x[at(same[v])];
}

}  // namespace

void relax_start(Garment& garment, double edge, const Mesh& body) {
  relax_start(garment, edge, body, InnerLayers(body));
}

void relax_start(Garment& garment, double edge, const Mesh& body, const InnerLayers& inner) {
  clear_arms(garment, body);
  inner.stand_outside(garment);
  std::vector<Vec3<double>>& x = garment.mesh.positions;
  const std::vector<Index> same = sewn_vertices(garment);
  sew_in_plane(garment, meeting_places(x, same), sweep_count(edge));
  std::vector<Tri> cloth = sewn_triangles(garment.mesh.triangles, same);
  inner.lift(cloth, x);
  contract_outside(garment, same, std::move(cloth), edge, joined(body, inner.mesh()), 0);
}

void tighten_start(Garment& garment, double edge, const Mesh& body, const InnerLayers& inner) {
  const std::vector<Index> same = sewn_vertices(garment);
  contract_outside(garment, same, sewn_triangles(garment.mesh.triangles, same), edge,
                   joined(body, inner.mesh()), tight_clearance);
}

void refuse_far_panels(const Garment& garment, const Mesh& body, const std::string& file) {
  if (body.positions.empty()) return;
  Aabb box;
  for (const Vec3<double>& p : body.positions) box.include(p);
  for (const GarmentPanel& panel : garment.panels) {
    double nearest = std::numeric_limits<double>::infinity();
    for (Index v = 0; v < panel.vertex_count; ++v) {
      const Vec3<double>& p = garment.mesh.positions[at(panel.first_vertex + v)];
      Vec3<double> away{0, 0, 0};
      for (int k = 0; k < 3; ++k) away[k] = std::max({box.lo[k] - p[k], p[k] - box.hi[k], 0.0});
      nearest = std::min(nearest, length(away));
    }
    if (nearest > most_panel_distance)
      throw SceneError(
          file, "pattern.panels." + panel.name,
          short_number(std::round(100 * nearest) / 100) + " m from the body",
          "panels that stand around it, at most " + short_number(most_panel_distance) + " m away");
  }
}

double largest_stretch(const Garment& garment) {
  double largest = 0;
  const Mesh& mesh = garment.mesh;
  for (const Tri& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) {
      const Index a = t.v[k], b = t.v[(k + 1) % 3];
      largest = std::max(
          largest, length(mesh.positions[at(a)] - mesh.positions[at(b)]) / rest_length(mesh, a, b));
    }
  return largest;
}

}  // namespace weft::io
