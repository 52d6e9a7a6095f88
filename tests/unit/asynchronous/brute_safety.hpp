#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "tests/unit/asynchronous/scenes.hpp"
#include "weft/elements/ccd.hpp"

namespace weft::test {

/// Checks the histories of accepted windows. What the engine's broad and narrow phases have no part
/// in: every pair, and certified continuous detection on every piece of its ways.
class BruteSafety {
 public:
  /// Looks at windows of `run` from now on, which must not outlive this.
  /// @param every of so many windows one
  void watch(WindowRun& run, int every = 1) {
    every_ = every;
    model_ = &run.model;
    place_ = run.windows.places();
    run.windows.observe(&look, this);
  }

  bool without_layers = false;  ///< checks as if pairs had none
  std::int64_t windows = 0;     ///< that were there
  std::int64_t tested = 0;      ///< slices of pairs whose boxes were that close
  std::int64_t violations = 0;  ///< pairs a window that came within eta(k + 1), k their layers

 private:
  /// Of a window: what is apart in all of them needs no look at its pieces.
  static constexpr std::size_t slices = 16;

  struct Box {
    Vec3<double> lo{1e300, 1e300, 1e300}, hi{-1e300, -1e300, -1e300};

    void include(const Box& b) {
      for (int a = 0; a < 3; ++a) {
        lo[a] = std::min(lo[a], b.lo[a]);
        hi[a] = std::max(hi[a], b.hi[a]);
      }
    }
    bool farther(const Box& b, double distance) const {
      for (int a = 0; a < 3; ++a)
        if (std::max(lo[a] - b.hi[a], b.lo[a] - hi[a]) > distance) return true;
      return false;
    }
  };

  static std::size_t at(Index i) { return static_cast<std::size_t>(i); }

  static void look(void* context, const Histories& trajectories, const ActiveLayers& layers,
                   const VertexMotion& motion, const LayerRule& rule) {
    static_cast<BruteSafety*>(context)->window(trajectories, layers, motion, rule);
  }

  Box box_of(const Index* v, int count) const {
    Box box;
    for (int c = 0; c < count; ++c) box.include(boxes_[at(place_[at(v[c])])]);
    return box;
  }

  void window(const Histories& histories, const ActiveLayers& layers, const VertexMotion& motion,
              const LayerRule& rule) {
    if (++windows % every_ != 0) return;
    first_time_ = histories.first_time();
    last_time_ = histories.last_time();
    trajectories_.clear();
    boxes_.assign(histories.size(), {});
    sliced_.assign(histories.size() * slices, {});
    for (std::size_t i = 0; i < histories.size(); ++i) {
      trajectories_.push_back(histories.way(i));
      slice(trajectories_[i], sliced_.data() + i * slices);
      for (std::size_t k = 0; k < slices; ++k) boxes_[i].include(sliced_[i * slices + k]);
    }
    std::vector<Box> faces, edges;
    for (const Tri& t : model_->triangles) faces.push_back(box_of(t.v, 3));
    for (const Edge& e : model_->edges) edges.push_back(box_of(e.v, 2));
    for (std::size_t f = 0; f < faces.size(); ++f)
      for (Index v = 0; v < model_->vertex_count; ++v) {
        if (faces[f].farther(boxes_[at(place_[at(v)])], rule.thickness)) continue;
        const Index* t = model_->triangles[f].v;
        pair(false, PrimitivePair::key_of(false, place_[at(v)], static_cast<Index>(f)),
             {v, t[0], t[1], t[2]}, layers, motion, rule);
      }
    for (std::size_t e = 0; e < edges.size(); ++e)
      for (std::size_t g = e + 1; g < edges.size(); ++g) {
        if (edges[e].farther(edges[g], rule.thickness)) continue;
        const Index* p = model_->edges[e].v;
        const Index* q = model_->edges[g].v;
        pair(true, PrimitivePair::key_of(true, static_cast<Index>(e), static_cast<Index>(g)),
             {p[0], p[1], q[0], q[1]}, layers, motion, rule);
      }
  }

  struct Corners {
    Index v[4];  ///< of the model
  };

  void pair(bool edges, std::uint64_t key, const Corners& of_model, const ActiveLayers& layers,
            const VertexMotion& motion, const LayerRule& rule) {
    const int first = edges ? 2 : 1;
    std::size_t v[4];
    bool movable = false;
    for (int c = 0; c < 4; ++c) {
      v[c] = at(place_[at(of_model.v[c])]);
      movable = movable || motion.inv_mass[v[c]] > 0;
    }
    for (int a = 0; a < first; ++a)
      for (int b = first; b < 4; ++b)
        if (v[a] == v[b]) return;
    if (!movable) return;
    // Continuous detection may see contact a thousandth above the distance.
    const double distance =
        rule.thickness_of((without_layers ? 0 : layers.depth(key)) + 1) * (1 - 2e-3);
    for (std::size_t k = 0; k < slices; ++k) {
      Box one, other;
      for (int c = 0; c < 4; ++c) (c < first ? one : other).include(sliced_[v[c] * slices + k]);
      if (one.farther(other, distance)) continue;
      ++tested;
      if (!slice_comes_within(edges, v, k, distance)) continue;
      ++violations;
      return;
    }
  }

  /// Continuous detection on every piece of one slice.
  bool slice_comes_within(bool edges, const std::size_t (&v)[4], std::size_t slice,
                          double distance) const {
    std::vector<double> times{slice_time(slice), slice_time(slice + 1)};
    for (const std::size_t i : v)
      for (const Breakpoint& k : trajectories_[i])
        if (k.t > times[0] && k.t < times[1]) times.push_back(k.t);
    std::sort(times.begin(), times.end());
    times.erase(std::unique(times.begin(), times.end()), times.end());
    Vec3<double> x0[4], x1[4];
    for (int c = 0; c < 4; ++c) x0[c] = position_at(trajectories_[v[c]], times[0]);
    for (std::size_t k = 1; k < times.size(); ++k) {
      for (int c = 0; c < 4; ++c) x1[c] = position_at(trajectories_[v[c]], times[k]);
      const auto impact =
          edges ? ccd_edge_edge(x0, x1, distance) : ccd_vertex_triangle(x0, x1, distance);
      if (impact.hit) return true;
      std::copy(x1, x1 + 4, x0);
    }
    return false;
  }

  double slice_time(std::size_t k) const {
    const double share = static_cast<double>(k) / slices;
    return first_time_ + share * (last_time_ - first_time_);
  }

  /// Boxes of a way's slices.
  void slice(const std::vector<Breakpoint>& way, Box* to) const {
    std::size_t next = 0;
    for (std::size_t k = 0; k < slices; ++k) {
      for (const double t : {slice_time(k), slice_time(k + 1)}) {
        const Vec3<double> x = position_at(way, t);
        to[k].include({x, x});
      }
      while (next < way.size() && way[next].t < slice_time(k)) ++next;
      for (; next < way.size() && way[next].t <= slice_time(k + 1); ++next)
        to[k].include({way[next].x, way[next].x});
    }
  }

  int every_ = 1;
  const Model* model_ = nullptr;
  std::vector<Index> place_;  ///< [vertices of the model]
  std::vector<std::vector<Breakpoint>> trajectories_;
  std::vector<Box> boxes_;   ///< [vertices] of their ways
  std::vector<Box> sliced_;  ///< [vertices][slices] as above
  double first_time_ = 0, last_time_ = 0;
};

}  // namespace weft::test
