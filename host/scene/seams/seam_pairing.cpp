#include "host/scene/seams/seam_pairing.hpp"

#include "weft/core/at.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <utility>

namespace weft {
namespace {

/// Vertices are a pair if the shares of their chains differ by up to this part of the shortest edge
/// at them. New vertices keep about as far from others, so no triangle becomes much thinner than
/// the meshes of both sides make it.
constexpr double pair_share = 0.3;
/// A flat band beside a tube is as near to it whichever way it winds. Front can only meet front if
/// two outlines run in opposite directions, so the other way has to be nearer by this factor.
constexpr double wrong_side = 1.5;
/// How many vertices of a chain are looked at to find where a closed one begins.
constexpr std::size_t looked_at_max = 256;

// ---- order

using Neighbours = std::map<Index, std::vector<Index>>;

/// @param outline only edges of one triangle
Neighbours neighbours_of(const SewnMesh& mesh, const std::vector<Index>& vertices, bool outline) {
  Neighbours neighbours;
  for (const Index v : vertices) neighbours[v];
  for (const auto& [edge, triangles] : mesh.edges()) {
    if (outline && triangles.size() != 1) continue;
    const auto a = neighbours.find(edge[0]), b = neighbours.find(edge[1]);
    if (a == neighbours.end() || b == neighbours.end()) continue;
    a->second.push_back(edge[1]);
    b->second.push_back(edge[0]);
  }
  return neighbours;
}

std::optional<VertexChain> chain_along(const Neighbours& neighbours) {
  std::optional<Index> end;
  for (const auto& [v, around] : neighbours) {
    if (around.empty() || around.size() > 2) return {};
    if (around.size() == 1 && !end) end = v;
  }
  VertexChain chain;
  chain.closed = !end;
  Index last = -1;
  Index here = end.value_or(neighbours.begin()->first);
  while (chain.vertices.size() < neighbours.size()) {
    chain.vertices.push_back(here);
    const std::vector<Index>& around = neighbours.at(here);
    const auto next =
        std::find_if(around.begin(), around.end(), [&](Index v) { return v != last; });
    if (next == around.end()) break;
    last = std::exchange(here, *next);
    if (here == chain.vertices.front()) break;
  }
  if (chain.vertices.size() != neighbours.size()) return {};
  return chain;
}

// ---- shares

/// A chain with its ends, which are one vertex if it is closed, and shares of its length.
struct Measured {
  std::vector<Index> vertices;
  std::vector<double> share;  ///< 0 to 1, increasing
};

double edge_sum(const SewnMesh& mesh, const std::vector<Index>& vertices,
                std::vector<double>* along) {
  double sum = 0;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    if (i > 0) sum += mesh.rest_length(vertices[i - 1], vertices[i]);
    if (along != nullptr) along->push_back(sum);
  }
  return sum;
}

std::vector<Index> with_both_ends(const VertexChain& chain) {
  std::vector<Index> vertices = chain.vertices;
  if (chain.closed) vertices.push_back(vertices.front());
  return vertices;
}

Measured measured(const SewnMesh& mesh, const VertexChain& chain) {
  Measured result{with_both_ends(chain), {}};
  const double whole = edge_sum(mesh, result.vertices, &result.share);
  for (double& share : result.share) share /= whole;
  result.share.back() = 1;
  return result;
}

/// [m] where a chain is at a share of its length
Vec3<double> place(const SewnMesh& mesh, const Measured& chain, double share) {
  const auto after = std::upper_bound(chain.share.begin() + 1, chain.share.end() - 1, share);
  const auto i = static_cast<std::size_t>(after - chain.share.begin());
  const auto& x = mesh.cloth().mesh.positions;
  const double part = (share - chain.share[i - 1]) / (chain.share[i] - chain.share[i - 1]);
  return (1 - part) * x[at(chain.vertices[i - 1])] + part * x[at(chain.vertices[i])];
}

/// [m^2] mean square of the distances between places of equal shares
double distance_sq(const std::array<SewnMesh*, 2>& meshes, const Measured& a, const Measured& b) {
  const std::size_t step = a.vertices.size() / looked_at_max + 1;
  double sum = 0;
  int count = 0;
  for (std::size_t i = 0; i < a.vertices.size(); i += step, ++count)
    sum += length_sq(meshes[0]->cloth().mesh.positions[at(a.vertices[i])] -
                     place(*meshes[1], b, a.share[i]));
  return sum / count;
}

/// Whether the front is to the left of a chain that runs along an outline; nothing: it does not.
std::optional<bool> front_is_left(const SewnMesh& mesh, const std::vector<Index>& vertices) {
  const Index a = vertices[0], b = vertices[1];
  const std::vector<Index>& triangles = mesh.edges().at({std::min(a, b), std::max(a, b)});
  if (triangles.size() != 1) return {};
  const Index* v = mesh.cloth().mesh.triangles[at(triangles.front())].v;
  const auto i = static_cast<std::size_t>(std::find(v, v + 3, a) - v);
  return v[(i + 1) % 3] == b;
}

/// Turns the second chain, and begins it elsewhere if it is closed, so that it is nearest to the
/// first one.
void align(const std::array<SewnMesh*, 2>& meshes, const VertexChain& first, VertexChain& second) {
  const Measured fixed = measured(*meshes[0], first);
  const std::size_t starts = second.closed ? second.vertices.size() : 1;
  const std::size_t step = starts / looked_at_max + 1;
  const std::optional<bool> left = front_is_left(*meshes[0], first.vertices);
  double best = std::numeric_limits<double>::infinity();
  VertexChain chosen = second;
  for (const bool turned : {false, true})
    for (std::size_t start = 0; start < starts; start += step) {
      VertexChain trial = second;
      std::rotate(trial.vertices.begin(),
                  trial.vertices.begin() + static_cast<std::ptrdiff_t>(start),
                  trial.vertices.end());
      // A closed chain keeps its first vertex.
      if (turned)
        std::reverse(trial.vertices.begin() + (second.closed ? 1 : 0), trial.vertices.end());
      double distance = distance_sq(meshes, fixed, measured(*meshes[1], trial));
      if (left && left == front_is_left(*meshes[1], trial.vertices)) distance *= wrong_side;
      if (!(distance < best)) continue;
      best = distance;
      chosen = std::move(trial);
    }
  second = std::move(chosen);
}

// ---- pairs

/// What comes after each other along a seam. A vertex that is not there yet is -1.
struct Stitch {
  std::array<Index, 2> vertex;
  std::array<double, 2> share;
};

/// Pairs what is between two pairs that are known.
class Pairing {
 public:
  Pairing(const Measured& a, const Measured& b) : side_{&a, &b} {}

  std::vector<Stitch> stitches() {
    const std::array<std::size_t, 2> last{side_[0]->share.size() - 1, side_[1]->share.size() - 1};
    put({0, 0});
    between({0, 0}, last);
    put(last);
    return std::move(stitches_);
  }

 private:
  using Place = std::array<std::size_t, 2>;  ///< of a vertex in each chain

  void put(const Place& p) {
    stitches_.push_back({{side_[0]->vertices[p[0]], side_[1]->vertices[p[1]]},
                         {side_[0]->share[p[0]], side_[1]->share[p[1]]}});
  }

  double local(std::size_t side, std::size_t i, const Place& low, const Place& high) const {
    const std::vector<double>& share = side_[side]->share;
    return (share[i] - share[low[side]]) / (share[high[side]] - share[low[side]]);
  }

  /// The vertex of the other chain between the ends that is nearest to one; `low`: there is none.
  std::size_t nearest(std::size_t side, std::size_t i, const Place& low, const Place& high) const {
    const std::size_t other = 1 - side;
    const double wanted = local(side, i, low, high);
    std::size_t best = low[other];
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t j = low[other] + 1; j < high[other]; ++j) {
      const double distance = std::abs(local(other, j, low, high) - wanted);
      if (distance < least) {
        least = distance;
        best = j;
      }
    }
    return best;
  }

  bool close(const Place& p, const Place& low, const Place& high) const {
    double shortest = 1;
    for (std::size_t side = 0; side < 2; ++side) {
      const double here = local(side, p[side], low, high);
      shortest = std::min({shortest, here - local(side, p[side] - 1, low, high),
                           local(side, p[side] + 1, low, high) - here});
    }
    return std::abs(local(0, p[0], low, high) - local(1, p[1], low, high)) <= pair_share * shortest;
  }

  void between(const Place& low, const Place& high) {
    std::vector<Place> found;
    for (std::size_t i = low[0] + 1; i < high[0]; ++i) {
      const std::size_t j = nearest(0, i, low, high);
      if (j != low[1] && nearest(1, j, low, high) == i && close({i, j}, low, high))
        found.push_back({i, j});
    }
    if (found.empty()) return put_all(low, high);
    // Each pair moves the shares of the vertices beside it a little, so others may be pairs now.
    Place last = low;
    for (const Place& p : found) {
      between(last, p);
      put(p);
      last = p;
    }
    between(last, high);
  }

  /// Gives each vertex between the ends a partner to be made.
  void put_all(const Place& low, const Place& high) {
    std::vector<std::pair<double, Stitch>> all;
    for (std::size_t side = 0; side < 2; ++side)
      for (std::size_t i = low[side] + 1; i < high[side]; ++i) {
        const double part = local(side, i, low, high);
        Stitch stitch{{-1, -1}, {}};
        stitch.vertex[side] = side_[side]->vertices[i];
        for (std::size_t k = 0; k < 2; ++k) {
          const std::vector<double>& share = side_[k]->share;
          stitch.share[k] = share[low[k]] + part * (share[high[k]] - share[low[k]]);
        }
        all.emplace_back(part, stitch);
      }
    std::stable_sort(all.begin(), all.end(),
                     [](const auto& p, const auto& q) { return p.first < q.first; });
    for (const auto& [part, stitch] : all) stitches_.push_back(stitch);
  }

  std::array<const Measured*, 2> side_;
  std::vector<Stitch> stitches_;
};

/// Puts vertices where stitches have none on one side.
void fill(SewnMesh& mesh, std::size_t side, std::vector<Stitch>& stitches) {
  for (std::size_t k = 1; k < stitches.size(); ++k) {
    if (stitches[k].vertex[side] >= 0) continue;
    std::size_t next = k;
    while (stitches[next].vertex[side] < 0) ++next;
    const double before = stitches[k - 1].share[side];
    const double part = (stitches[k].share[side] - before) / (stitches[next].share[side] - before);
    stitches[k].vertex[side] =
        mesh.split(stitches[k - 1].vertex[side], stitches[next].vertex[side], part);
  }
}

}  // namespace

std::optional<VertexChain> chain_of(const SewnMesh& mesh, const std::vector<Index>& vertices) {
  if (vertices.size() < 2) return {};
  if (const auto outline = chain_along(neighbours_of(mesh, vertices, true))) return outline;
  return chain_along(neighbours_of(mesh, vertices, false));
}

std::optional<VertexChain> in_order(const std::vector<Index>& given, VertexChain chain) {
  const bool closed = given.size() > 2 && given.front() == given.back();
  if (closed != chain.closed) return {};
  std::vector<Index>& vertices = chain.vertices;
  const auto runs = [&] {
    auto here = vertices.begin();
    const auto end = given.end() - (closed ? 1 : 0);
    for (auto v = given.begin(); v != end; ++v, ++here) {
      here = std::find(here, vertices.end(), *v);
      if (here == vertices.end()) return false;
    }
    return vertices.front() == given.front() && (closed || vertices.back() == given.back());
  };
  for (int turned = 0; turned < 2; ++turned) {
    if (turned == 1) std::reverse(vertices.begin(), vertices.end());
    if (closed) {
      const auto first = std::find(vertices.begin(), vertices.end(), given.front());
      std::rotate(vertices.begin(), first, vertices.end());
    }
    if (runs()) return chain;
  }
  return {};
}

bool overlap(const VertexChain& a, const VertexChain& b) {
  const auto is_end = [](const VertexChain& chain, Index v) {
    return !chain.closed && (v == chain.vertices.front() || v == chain.vertices.back());
  };
  return std::any_of(a.vertices.begin(), a.vertices.end(), [&](Index v) {
    return std::find(b.vertices.begin(), b.vertices.end(), v) != b.vertices.end() &&
           !(is_end(a, v) && is_end(b, v));
  });
}

double rest_length(const SewnMesh& mesh, const VertexChain& chain) {
  return edge_sum(mesh, with_both_ends(chain), nullptr);
}

std::array<std::vector<Index>, 2> pair_by_length(const std::array<SewnMesh*, 2>& meshes,
                                                 std::array<VertexChain, 2> chains,
                                                 bool keep_direction) {
  if (!keep_direction) {
    // Of an open chain and a closed one, the open one says where the other begins.
    if (chains[0].closed && !chains[1].closed)
      align({meshes[1], meshes[0]}, chains[1], chains[0]);
    else
      align(meshes, chains[0], chains[1]);
  }
  const Measured a = measured(*meshes[0], chains[0]);
  const Measured b = measured(*meshes[1], chains[1]);
  std::vector<Stitch> stitches = Pairing(a, b).stitches();
  for (std::size_t side = 0; side < 2; ++side) fill(*meshes[side], side, stitches);
  if (chains[0].closed && chains[1].closed) stitches.pop_back();
  std::array<std::vector<Index>, 2> pairs;
  for (const Stitch& stitch : stitches) {
    if (meshes[0] == meshes[1] && stitch.vertex[0] == stitch.vertex[1]) continue;
    for (std::size_t side = 0; side < 2; ++side) pairs[side].push_back(stitch.vertex[side]);
  }
  return pairs;
}

}  // namespace weft
