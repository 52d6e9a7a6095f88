#include "host/asynchronous/detection.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/asynchronous/gap.hpp"
#include "host/model/surface_tables.hpp"
#include "weft/core/at.hpp"

namespace weft {
namespace {

constexpr std::size_t least_items_per_thread = 128;
/// A window that is rolled back anyway gives a layer to pairs too that come within so much of its
/// thickness: many of them would ask for it next.
constexpr double look_ahead = 1.1;
/// Pairs that come within so much of the first layer may be in it before the next window ends.
constexpr double expecting = 1.5;
/// If paths deviate from their chords by no more than this share of the first layer's thickness,
/// their breakpoints need not be examined.
constexpr double straight_share = 0.1;
/// Gaps have to be larger than a distance by this share of it, which is much more than what
/// rounding takes from their ratios.
constexpr double gap_margin = 1e-6;
/// Vertices whose extents fit into the nearest cache.
constexpr std::size_t swept_at_once = 32;
/// Pairs that a thread takes at a time.
constexpr std::size_t pairs_a_turn = 64;

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

/// @param straight [m] paths that deviate less are treated as chords of that thickness
void Detection::sweep(const Histories& trajectories, double straight, Workers& workers) {
  workers.share(swept_.size(), least_items_per_thread, [&](std::size_t a, std::size_t b) {
    for (std::size_t i = a; i < b; i += swept_at_once) {
      const std::size_t end = std::min(i + swept_at_once, b);
      trajectories.chords(i, end, chords_.data() + i);
      for (std::size_t k = i; k < end; ++k) {
        Extent extent;
        extent.include(chords_[k].from);
        extent.include(chords_[k].to);
        if (chords_[k].deviation < straight)
          extent.widen(chords_[k].deviation);
        else
          trajectories.include(k, k + 1, &extent);
        swept_[k] = Dop(extent);
      }
    }
  });
}

/// Copies the ways of the corners of open candidates to where they stand one by one.
void Detection::collect(const Histories& trajectories, Workers& workers) {
  trajectory_.assign(trajectories.size(), {});
  corners_.clear();
  first_breakpoint_.assign(1, 0);
  for (const Candidate* candidate : open_)
    for (const Index v : candidate->pair.v) {
      if (seen_[at(v)] != 0) continue;
      seen_[at(v)] = 1;
      corners_.push_back(v);
      first_breakpoint_.push_back(first_breakpoint_.back() + trajectories.most_breakpoints(at(v)));
    }
  if (breakpoints_.size() < first_breakpoint_.back()) breakpoints_.resize(first_breakpoint_.back());
  workers.share(corners_.size(), least_items_per_thread, [&](std::size_t a, std::size_t b) {
    for (std::size_t k = a; k < b; ++k) {
      Breakpoint* const to = breakpoints_.data() + first_breakpoint_[k];
      trajectory_[at(corners_[k])] = {to, trajectories.copy(at(corners_[k]), to)};
    }
  });
  for (const Index v : corners_) seen_[at(v)] = 0;
}

/// @param a, b what the two primitives sweep
void Detection::add_pair(const PrimitivePair& pair, const Dop& a, const Dop& b,
                         const Search& search, Found& to) const {
  const int first = pair.first_count();
  for (int c = 0; c < first; ++c)
    for (int d = first; d < 4; ++d)
      if (pair.v[c] == pair.v[d]) return;
  if (a.farther(b, dop_distance(search.distance + rounding_))) return;
  bool movable = false;
  for (const Index v : pair.v) movable = movable || search.motion.inv_mass[at(v)] > 0;
  if (!movable) return;
  if (search.layers == nullptr) {
    to.candidates.push_back({pair, 0, false, 0});
    return;
  }
  const Chord* corners[4];
  for (int c = 0; c < 4; ++c) corners[c] = &chords_[at(pair.v[c])];
  double apart = a.gap(b) - rounding_;
  const double approach = most_approach(pair, corners);
  // Nobody asks for more than that, whatever the pair's layers are: most need not be looked up.
  const auto idle = [&](int depth) {
    return apart > look_ahead * search.rule.thickness_of(depth + 1) + approach;
  };
  int depth = 0;
  if (idle(0) || idle(depth = search.layers->depth(pair.key))) {
    ++to.passed_over;
    return;
  }
  if (slabs_ && !(apart > look_ahead * search.rule.thickness_of(depth + 1)))
    apart = std::max(apart, (least_gap(pair, corners) - rounding_) / (1 + gap_margin));
  to.candidates.push_back({pair, depth, false, apart});
}

/// The pairs of two triangles that these own.
void Detection::add_pairs(std::size_t s, std::size_t t, const Search& search, Found& to) const {
  const std::size_t both[2][2] = {{s, t}, {t, s}};
  for (const auto& [own, other] : both)
    for (const Index v : triangles_[own].v) {
      if (owner_of_vertex_[at(v)] != static_cast<Index>(own)) continue;
      const Tri& f = triangles_[other];
      add_pair(
          {PrimitivePair::key_of(false, v, static_cast<Index>(other)), {v, f.v[0], f.v[1], f.v[2]}},
          swept_[at(v)], hierarchy_.of_triangle(other), search, to);
    }
  for (const Index e : edges_of_[s].v) {
    if (owner_of_edge_[at(e)] != static_cast<Index>(s)) continue;
    for (const Index g : edges_of_[t].v) {
      if (owner_of_edge_[at(g)] != static_cast<Index>(t)) continue;
      const Index low = std::min(e, g), high = std::max(e, g);
      const Index* p = edges_[at(low)].v;
      const Index* q = edges_[at(high)].v;
      add_pair({PrimitivePair::key_of(true, low, high), {p[0], p[1], q[0], q[1]}},
               edges_swept_[at(low)], edges_swept_[at(high)], search, to);
    }
  }
}

/// Fills found_.
void Detection::near(const Search& search, Workers& workers) {
  double reach = 0;
  for (const Dop& dop : swept_)
    for (int k = 0; k < 3; ++k)
      reach = std::max({reach, double(std::abs(dop.lo[k])), double(std::abs(dop.hi[k]))});
  rounding_ = 64 * std::numeric_limits<double>::epsilon() * (reach + search.rule.thickness);
  workers.share(edges_.size(), least_items_per_thread, [&](std::size_t a, std::size_t b) {
    for (std::size_t e = a; e < b; ++e) {
      edges_swept_[e] = swept_[at(edges_[e].v[0])];
      edges_swept_[e].include(swept_[at(edges_[e].v[1])]);
    }
  });
  hierarchy_.fit(swept_, workers);
  for (Found& found : found_) {
    found.candidates.clear();
    found.passed_over = 0;
  }
  hierarchy_.visit(
      dop_distance(search.distance + rounding_), self_, workers,
      [&](std::size_t tasks) { found_.resize(std::max(tasks, found_.size())); },
      [&](std::size_t task, std::size_t s, std::size_t t) {
        add_pairs(s, t, search, found_[task]);
      });
}

/// The narrow phase for those candidates whose chords leave it open.
/// @param share  of their next layers' thickness
/// @param missed those that come within it are added; what is there already is passed over
void Detection::look(double share, const Histories& trajectories, const LayerRule& rule,
                     const WorkerGroup& group, std::atomic<bool>& any, NarrowCounts& counts,
                     std::vector<PrimitivePair>& missed) {
  const auto distance = [&](const Candidate& c) { return share * rule.thickness_of(c.depth + 1); };
  open_.clear();
  for (Found& found : found_)
    for (Candidate& candidate : found.candidates)
      if (!candidate.missed && !(candidate.apart > distance(candidate)))
        open_.push_back(&candidate);
  collect(trajectories, group.workers());
  const std::size_t turns = (open_.size() + pairs_a_turn - 1) / pairs_a_turn;
  std::vector<NarrowCounts> narrow(turns);
  group.workers().take_turns(turns, [&](std::size_t k) {
    const std::size_t end = std::min(open_.size(), (k + 1) * pairs_a_turn);
    for (std::size_t i = k * pairs_a_turn; i < end; ++i) {
      Candidate& candidate = *open_[i];
      Trajectory corners[4];
      for (int c = 0; c < 4; ++c) corners[c] = trajectory_[at(candidate.pair.v[c])];
      candidate.missed =
          comes_within(candidate.pair, corners, distance(candidate), slabs_, rounding_, narrow[k]);
      if (candidate.missed) any.store(true, std::memory_order_relaxed);
    }
  });
  for (const Candidate* candidate : open_)
    if (candidate->missed) missed.push_back(candidate->pair);
  for (const NarrowCounts& part : narrow) counts += part;
}

std::vector<PrimitivePair> Detection::missed(const Histories& trajectories,
                                             const VertexMotion& motion, const ActiveLayers& layers,
                                             const LayerRule& rule, const WorkerGroup& group,
                                             std::atomic<bool>& any, DetectionCounts& counts) {
  sweep(trajectories, straight_share * rule.thickness, group.workers());
  near({motion, rule, expecting * rule.thickness, &layers}, group.workers());
  for (const Found& found : found_)
    counts.candidates += static_cast<std::int64_t>(found.candidates.size()) + found.passed_over;
  std::vector<PrimitivePair> missed;
  look(1, trajectories, rule, group, any, counts.narrow, missed);
  if (!missed.empty()) look(look_ahead, trajectories, rule, group, any, counts.narrow, missed);
  sort_by_key(missed);
  return missed;
}

bool Detection::expects(const Candidate& candidate, const LayerRule& rule) const {
  const double wanted = look_ahead * rule.thickness_of(candidate.depth + 1);
  const Chord* corners[4];
  Vec3<double> x[4];
  for (int c = 0; c < 4; ++c) {
    corners[c] = &chords_[at(candidate.pair.v[c])];
    x[c] = corners[c]->to;
  }
  if (candidate.apart > wanted + most_approach(candidate.pair, corners)) return false;
  const Proximity<double> p = candidate.pair.closest(x);
  const double d = std::sqrt(p.distance_sq);
  double going = 0;
  for (int c = 0; c < 4; ++c)
    going += p.w[c] * dot(p.difference, corners[c]->to - corners[c]->from);
  return d > 0 && d + going / d < wanted;
}

std::vector<PrimitivePair> Detection::expected(const LayerRule& rule, Workers& workers) const {
  std::vector<std::vector<PrimitivePair>> parts(found_.size());
  workers.take_turns(found_.size(), [&](std::size_t k) {
    for (const Candidate& candidate : found_[k].candidates)
      if (expects(candidate, rule)) parts[k].push_back(candidate.pair);
  });
  std::vector<PrimitivePair> all;
  for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
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
  near({motion, rule, rule.thickness, nullptr}, workers);
  for (const Found& found : found_)
    for (const Candidate& candidate : found.candidates) {
      const PrimitivePair& pair = candidate.pair;
      Vec3<double> x[4];
      for (int c = 0; c < 4; ++c) x[c] = motion.position(at(pair.v[c]), time);
      const double d = std::sqrt(pair.closest(x).distance_sq);
      all.push_back({pair, rule.layers_within(d, most)});
    }
  return all;
}

}  // namespace weft
