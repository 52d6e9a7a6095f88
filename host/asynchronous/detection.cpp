#include "host/asynchronous/detection.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/scene/surface_tables.hpp"

namespace weft {
namespace {

constexpr std::size_t least_share = 128;
/// A window that is rolled back anyway gives a layer to pairs too that come within so much of its
/// thickness: many of them would ask for it next.
constexpr double look_ahead = 1.1;
/// Pairs that come within so much of the first layer may be in it before the next window ends.
constexpr double expecting = 1.5;
/// Vertices whose extents fit into the nearest cache.
constexpr std::size_t swept_at_once = 32;
/// Pairs that a thread takes at a time.
constexpr std::size_t pairs_a_turn = 64;

std::size_t at(Index i) {
  return static_cast<std::size_t>(i);
}

std::vector<Tri> renumbered_triangles(const Model& model, const std::vector<Index>& place) {
  std::vector<Tri> triangles = model.triangles;
  for (Tri& t : triangles)
    for (Index& v : t.v) v = place[at(v)];
  return triangles;
}

void sort_by_key(std::vector<PrimitivePair>& pairs) {
  std::sort(pairs.begin(), pairs.end(),
            [](const PrimitivePair& a, const PrimitivePair& b) { return a.key < b.key; });
}

}  // namespace

Detection::Detection(const Scene& scene, const Model& model, const std::vector<Index>& place,
                     bool slabs)
    : self_(scene.contact.self),
      slabs_(slabs),
      triangles_(renumbered_triangles(model, place)),
      edges_(model.edges),
      edges_of_(make_surface_tables(model).edges_of_face),
      owner_of_vertex_(at(model.vertex_count), -1),
      owner_of_edge_(model.edges.size(), -1),
      hierarchy_(triangles_, at(model.cloth_triangle_count)),
      swept_(at(model.vertex_count)),
      seen_(at(model.vertex_count), 0),
      edges_swept_(model.edges.size()) {
  for (Edge& e : edges_)
    for (Index& v : e.v) v = place[at(v)];
  for (std::size_t t = triangles_.size(); t-- > 0;)
    for (int k = 0; k < 3; ++k) {
      owner_of_vertex_[at(triangles_[t].v[k])] = static_cast<Index>(t);
      owner_of_edge_[at(edges_of_[t].v[k])] = static_cast<Index>(t);
    }
}

void Detection::sweep(const Histories& ways, Workers& workers) {
  workers.share(swept_.size(), least_share, [&](std::size_t a, std::size_t b) {
    for (std::size_t i = a; i < b; i += swept_at_once) {
      const std::size_t end = std::min(i + swept_at_once, b);
      Extent extents[swept_at_once];
      ways.include(i, end, extents);
      for (std::size_t k = i; k < end; ++k) swept_[k] = Dop(extents[k - i]);
    }
  });
}

/// Copies the ways of the corners of pairs to where they stand one by one.
void Detection::collect(const Histories& ways, const std::vector<PrimitivePair>& pairs,
                        Workers& workers) {
  trajectory_.assign(ways.size(), {});
  corners_.clear();
  first_knot_.assign(1, 0);
  for (const PrimitivePair& pair : pairs)
    for (const Index v : pair.v) {
      if (seen_[at(v)] != 0) continue;
      seen_[at(v)] = 1;
      corners_.push_back(v);
      first_knot_.push_back(first_knot_.back() + ways.most_knots(at(v)));
    }
  if (knots_.size() < first_knot_.back()) knots_.resize(first_knot_.back());
  workers.share(corners_.size(), least_share, [&](std::size_t a, std::size_t b) {
    for (std::size_t k = a; k < b; ++k) {
      Knot* const to = knots_.data() + first_knot_[k];
      trajectory_[at(corners_[k])] = {to, ways.copy(at(corners_[k]), to)};
    }
  });
  for (const Index v : corners_) seen_[at(v)] = 0;
}

/// @param a, b what the two primitives sweep
void Detection::add_pair(const PrimitivePair& pair, const Dop& a, const Dop& b,
                         const VertexMotion& motion, const ActiveLayers* layers,
                         const LayerRule& rule, std::vector<PrimitivePair>& to) const {
  const int first = pair.first_count();
  for (int c = 0; c < first; ++c)
    for (int d = first; d < 4; ++d)
      if (pair.v[c] == pair.v[d]) return;
  if (a.farther(b, dop_distance(near_distance_ + rounding_))) return;
  bool movable = false;
  for (const Index v : pair.v) movable = movable || motion.inv_mass[at(v)] > 0;
  if (!movable) return;
  const int depth = layers != nullptr ? layers->depth(pair.key) : 0;
  if (depth > 0 && a.farther(b, dop_distance(rule.thickness_of(depth + 1) + rounding_))) return;
  to.push_back(pair);
}

/// The pairs of two triangles that these own.
void Detection::add_pairs(std::size_t s, std::size_t t, const VertexMotion& motion,
                          const ActiveLayers* layers, const LayerRule& rule,
                          std::vector<PrimitivePair>& to) const {
  const std::size_t both[2][2] = {{s, t}, {t, s}};
  for (const auto& [own, other] : both)
    for (const Index v : triangles_[own].v) {
      if (owner_of_vertex_[at(v)] != static_cast<Index>(own)) continue;
      const Tri& f = triangles_[other];
      add_pair(
          {PrimitivePair::key_of(false, v, static_cast<Index>(other)), {v, f.v[0], f.v[1], f.v[2]}},
          swept_[at(v)], hierarchy_.of_triangle(other), motion, layers, rule, to);
    }
  for (const Index e : edges_of_[s].v) {
    if (owner_of_edge_[at(e)] != static_cast<Index>(s)) continue;
    for (const Index g : edges_of_[t].v) {
      if (owner_of_edge_[at(g)] != static_cast<Index>(t)) continue;
      const Index low = std::min(e, g), high = std::max(e, g);
      const Index* p = edges_[at(low)].v;
      const Index* q = edges_[at(high)].v;
      add_pair({PrimitivePair::key_of(true, low, high), {p[0], p[1], q[0], q[1]}},
               edges_swept_[at(low)], edges_swept_[at(high)], motion, layers, rule, to);
    }
  }
}

std::vector<PrimitivePair> Detection::near(const VertexMotion& motion, double distance,
                                           Workers& workers, const ActiveLayers* layers,
                                           const LayerRule& rule) {
  near_distance_ = distance;
  double reach = 0;
  for (const Dop& dop : swept_)
    for (int k = 0; k < 3; ++k)
      reach = std::max({reach, double(std::abs(dop.lo[k])), double(std::abs(dop.hi[k]))});
  rounding_ = 64 * std::numeric_limits<double>::epsilon() * (reach + rule.thickness);
  workers.share(edges_.size(), least_share, [&](std::size_t a, std::size_t b) {
    for (std::size_t e = a; e < b; ++e) {
      edges_swept_[e] = swept_[at(edges_[e].v[0])];
      edges_swept_[e].include(swept_[at(edges_[e].v[1])]);
    }
  });
  hierarchy_.fit(swept_, workers);
  std::vector<std::vector<PrimitivePair>> found;
  hierarchy_.visit(
      dop_distance(distance + rounding_), self_, workers,
      [&](std::size_t tasks) { found.resize(tasks); },
      [&](std::size_t task, std::size_t s, std::size_t t) {
        add_pairs(s, t, motion, layers, rule, found[task]);
      });
  std::vector<PrimitivePair> all;
  for (const auto& part : found) all.insert(all.end(), part.begin(), part.end());
  return all;
}

std::vector<PrimitivePair> Detection::missed(const Histories& ways, const VertexMotion& motion,
                                             const ActiveLayers& layers, const LayerRule& rule,
                                             const Hands& hands, std::atomic<bool>& any,
                                             DetectionCounts& counts) {
  sweep(ways, hands.workers());
  pairs_ = near(motion, expecting * rule.thickness, hands.workers(), &layers, rule);
  const std::vector<PrimitivePair>& pairs = pairs_;
  counts.candidates += static_cast<std::int64_t>(pairs.size());
  collect(ways, pairs, hands.workers());
  const std::size_t turns = (pairs.size() + pairs_a_turn - 1) / pairs_a_turn;
  std::vector<std::vector<PrimitivePair>> found(turns);
  std::vector<NarrowCounts> narrow(turns);
  const auto look = [&](double share, auto&& skip, std::vector<std::vector<PrimitivePair>>& to) {
    hands.workers().take_turns(turns, [&](std::size_t k) {
      const std::size_t end = std::min(pairs.size(), (k + 1) * pairs_a_turn);
      for (std::size_t i = k * pairs_a_turn; i < end; ++i) {
        const PrimitivePair& pair = pairs[i];
        if (skip(k, pair)) continue;
        const Trajectory corners[4] = {trajectory_[at(pair.v[0])], trajectory_[at(pair.v[1])],
                                       trajectory_[at(pair.v[2])], trajectory_[at(pair.v[3])]};
        const double distance = share * rule.thickness_of(layers.depth(pair.key) + 1);
        if (!comes_within(pair, corners, distance, slabs_, rounding_, narrow[k])) continue;
        to[k].push_back(pair);
        any.store(true, std::memory_order_relaxed);
      }
    });
  };
  look(
      1, [](std::size_t, const PrimitivePair&) { return false; }, found);
  std::vector<PrimitivePair> all;
  for (const auto& part : found) all.insert(all.end(), part.begin(), part.end());
  if (!all.empty()) {
    std::vector<std::vector<PrimitivePair>> close(turns);
    look(
        look_ahead,
        [&](std::size_t k, const PrimitivePair& pair) {
          return std::any_of(found[k].begin(), found[k].end(),
                             [&](const PrimitivePair& f) { return f.key == pair.key; });
        },
        close);
    for (const auto& part : close) all.insert(all.end(), part.begin(), part.end());
  }
  for (const NarrowCounts& part : narrow) counts.narrow += part;
  sort_by_key(all);
  return all;
}

std::vector<PrimitivePair> Detection::expected(const ActiveLayers& layers,
                                               const LayerRule& rule) const {
  std::vector<PrimitivePair> all;
  for (const PrimitivePair& pair : pairs_) {
    Vec3<double> x[4], way[4];
    for (int c = 0; c < 4; ++c) {
      const Trajectory& knots = trajectory_[at(pair.v[c])];
      x[c] = knots[knots.size() - 1].x;
      way[c] = x[c] - knots[0].x;
    }
    const Proximity<double> p = pair.closest(x);
    const double d = std::sqrt(p.distance_sq);
    double going = 0;
    for (int c = 0; c < 4; ++c) going += p.w[c] * dot(p.difference, way[c]);
    if (d > 0 && d + going / d < look_ahead * rule.thickness_of(layers.depth(pair.key) + 1))
      all.push_back(pair);
  }
  sort_by_key(all);
  return all;
}

std::vector<LayeredPair> Detection::within(const VertexMotion& motion, double time,
                                           const LayerRule& rule, int most, Workers& workers) {
  for (std::size_t i = 0; i < swept_.size(); ++i) {
    Extent extent;
    extent.include(motion.position(i, time));
    swept_[i] = Dop(extent);
  }
  std::vector<LayeredPair> all;
  for (const PrimitivePair& pair : near(motion, rule.thickness, workers, nullptr, rule)) {
    Vec3<double> x[4];
    for (int c = 0; c < 4; ++c) x[c] = motion.position(at(pair.v[c]), time);
    const double d = std::sqrt(pair.closest(x).distance_sq);
    all.push_back({pair, rule.layers_within(d, most)});
  }
  return all;
}

}  // namespace weft
