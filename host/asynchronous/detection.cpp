#include "host/asynchronous/detection.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/asynchronous/gap.hpp"
#include "host/scene/surface_tables.hpp"

namespace weft {
namespace {

constexpr std::size_t least_share = 128;
/// A window that is rolled back anyway gives a layer to pairs too that come within so much of its
/// thickness: many of them would ask for it next.
constexpr double look_ahead = 1.1;
/// Pairs that come within so much of the first layer may be in it before the next window ends.
constexpr double expecting = 1.5;
/// Ways that go astray from their chords by no more than this share of the first layer's thickness
/// need no look at their knots.
constexpr double straight_share = 0.02;
/// Gaps have to be larger than a distance by this share of it, which is much more than what
/// rounding takes from their ratios.
constexpr double gap_margin = 1e-6;
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
      chords_(at(model.vertex_count)),
      edges_swept_(model.edges.size()) {
  for (Edge& e : edges_)
    for (Index& v : e.v) v = place[at(v)];
  for (std::size_t t = triangles_.size(); t-- > 0;)
    for (int k = 0; k < 3; ++k) {
      owner_of_vertex_[at(triangles_[t].v[k])] = static_cast<Index>(t);
      owner_of_edge_[at(edges_of_[t].v[k])] = static_cast<Index>(t);
    }
}

/// @param straight [m] ways that go less astray are taken for chords of that thickness
void Detection::sweep(const Histories& ways, double straight, Workers& workers) {
  workers.share(swept_.size(), least_share, [&](std::size_t a, std::size_t b) {
    for (std::size_t i = a; i < b; i += swept_at_once) {
      const std::size_t end = std::min(i + swept_at_once, b);
      ways.chords(i, end, chords_.data() + i);
      for (std::size_t k = i; k < end; ++k) {
        Extent extent;
        extent.include(chords_[k].from);
        extent.include(chords_[k].to);
        if (chords_[k].astray < straight)
          extent.widen(chords_[k].astray);
        else
          ways.include(k, k + 1, &extent);
        swept_[k] = Dop(extent);
      }
    }
  });
}

/// Copies the ways of the corners of open candidates to where they stand one by one.
void Detection::collect(const Histories& ways, Workers& workers) {
  trajectory_.assign(ways.size(), {});
  corners_.clear();
  first_knot_.assign(1, 0);
  for (const std::size_t i : open_)
    for (const Index v : candidates_[i].pair.v) {
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
                         const LayerRule& rule, std::vector<Candidate>& to) const {
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
  to.push_back({pair, depth, false, slabs_ ? a.gap(b) - rounding_ : 0});
}

/// The pairs of two triangles that these own.
void Detection::add_pairs(std::size_t s, std::size_t t, const VertexMotion& motion,
                          const ActiveLayers* layers, const LayerRule& rule,
                          std::vector<Candidate>& to) const {
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

std::vector<Detection::Candidate> Detection::near(const VertexMotion& motion, double distance,
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
  std::vector<std::vector<Candidate>> found;
  hierarchy_.visit(
      dop_distance(distance + rounding_), self_, workers,
      [&](std::size_t tasks) { found.resize(tasks); },
      [&](std::size_t task, std::size_t s, std::size_t t) {
        add_pairs(s, t, motion, layers, rule, found[task]);
      });
  std::vector<Candidate> all;
  for (const auto& part : found) all.insert(all.end(), part.begin(), part.end());
  return all;
}

/// How far those candidates are apart for certain whose polytopes do not show that they stay beyond
/// their next layers, as far as their corners' chords show it.
void Detection::find_gaps(const LayerRule& rule, Workers& workers) {
  workers.share(candidates_.size(), least_share, [&](std::size_t a, std::size_t b) {
    for (std::size_t i = a; i < b; ++i) {
      Candidate& candidate = candidates_[i];
      if (candidate.apart > look_ahead * rule.thickness_of(candidate.depth + 1)) continue;
      const Chord* corners[4];
      for (int c = 0; c < 4; ++c) corners[c] = &chords_[at(candidate.pair.v[c])];
      const double gap = (least_gap(candidate.pair, corners) - rounding_) / (1 + gap_margin);
      candidate.apart = std::max(candidate.apart, gap);
    }
  });
}

/// The narrow phase for those candidates whose chords leave it open.
/// @param share of their next layers' thickness
/// @param found those that come within it are added; what is there already is passed over
void Detection::look(double share, const Histories& ways, const LayerRule& rule, const Hands& hands,
                     std::atomic<bool>& any, NarrowCounts& counts,
                     std::vector<PrimitivePair>& found) {
  const auto distance = [&](const Candidate& c) { return share * rule.thickness_of(c.depth + 1); };
  open_.clear();
  for (std::size_t i = 0; i < candidates_.size(); ++i)
    if (!candidates_[i].missed && !(candidates_[i].apart > distance(candidates_[i])))
      open_.push_back(i);
  collect(ways, hands.workers());
  const std::size_t turns = (open_.size() + pairs_a_turn - 1) / pairs_a_turn;
  std::vector<NarrowCounts> narrow(turns);
  hands.workers().take_turns(turns, [&](std::size_t k) {
    const std::size_t end = std::min(open_.size(), (k + 1) * pairs_a_turn);
    for (std::size_t i = k * pairs_a_turn; i < end; ++i) {
      Candidate& candidate = candidates_[open_[i]];
      Trajectory corners[4];
      for (int c = 0; c < 4; ++c) corners[c] = trajectory_[at(candidate.pair.v[c])];
      candidate.missed =
          comes_within(candidate.pair, corners, distance(candidate), slabs_, rounding_, narrow[k]);
      if (candidate.missed) any.store(true, std::memory_order_relaxed);
    }
  });
  for (const std::size_t i : open_)
    if (candidates_[i].missed) found.push_back(candidates_[i].pair);
  for (const NarrowCounts& part : narrow) counts += part;
}

std::vector<PrimitivePair> Detection::missed(const Histories& ways, const VertexMotion& motion,
                                             const ActiveLayers& layers, const LayerRule& rule,
                                             const Hands& hands, std::atomic<bool>& any,
                                             DetectionCounts& counts) {
  sweep(ways, straight_share * rule.thickness, hands.workers());
  candidates_ = near(motion, expecting * rule.thickness, hands.workers(), &layers, rule);
  counts.candidates += static_cast<std::int64_t>(candidates_.size());
  if (slabs_) find_gaps(rule, hands.workers());
  std::vector<PrimitivePair> found;
  look(1, ways, rule, hands, any, counts.narrow, found);
  if (!found.empty()) look(look_ahead, ways, rule, hands, any, counts.narrow, found);
  sort_by_key(found);
  return found;
}

bool Detection::expects(const Candidate& candidate, const LayerRule& rule) const {
  const double wanted = look_ahead * rule.thickness_of(candidate.depth + 1);
  Vec3<double> x[4], way[4], mean{};
  for (int c = 0; c < 4; ++c) {
    const Chord& chord = chords_[at(candidate.pair.v[c])];
    x[c] = chord.to;
    way[c] = chord.to - chord.from;
    mean += way[c] * 0.25;
  }
  // Nearest points differ in their ways by no more than corners do.
  double most[2] = {0, 0};
  for (int c = 0; c < 4; ++c) {
    double& of = most[c < candidate.pair.first_count() ? 0 : 1];
    of = std::max(of, length_sq(way[c] - mean));
  }
  if (candidate.apart > wanted + std::sqrt(most[0]) + std::sqrt(most[1])) return false;
  const Proximity<double> p = candidate.pair.closest(x);
  const double d = std::sqrt(p.distance_sq);
  double going = 0;
  for (int c = 0; c < 4; ++c) going += p.w[c] * dot(p.difference, way[c]);
  return d > 0 && d + going / d < wanted;
}

std::vector<PrimitivePair> Detection::expected(const LayerRule& rule, Workers& workers) const {
  std::vector<unsigned char> is_expected(candidates_.size());
  workers.share(candidates_.size(), least_share, [&](std::size_t a, std::size_t b) {
    for (std::size_t i = a; i < b; ++i) is_expected[i] = expects(candidates_[i], rule) ? 1 : 0;
  });
  std::vector<PrimitivePair> all;
  for (std::size_t i = 0; i < candidates_.size(); ++i)
    if (is_expected[i] != 0) all.push_back(candidates_[i].pair);
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
  for (const Candidate& candidate : near(motion, rule.thickness, workers, nullptr, rule)) {
    const PrimitivePair& pair = candidate.pair;
    Vec3<double> x[4];
    for (int c = 0; c < 4; ++c) x[c] = motion.position(at(pair.v[c]), time);
    const double d = std::sqrt(pair.closest(x).distance_sq);
    all.push_back({pair, rule.layers_within(d, most)});
  }
  return all;
}

}  // namespace weft
