#include "host/model/plate.hpp"

#include <Eigen/Dense>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "host/base/parallel.hpp"
#include "host/model/plate_notes.hpp"
#include "host/model/plate_patch.hpp"
#include "weft/core/at.hpp"
#include "weft/core/span.hpp"
#include "weft/elements/triangle_frame.hpp"

namespace weft {
namespace {

using Point = PlatePatches::Point;

/// Entries below this share of their diagonals are what rounding leaves of a zero.
constexpr double negligible = 1e-12;
/// Rows that are added up together: few enough for a cache, and so many that few triangles and
/// edges belong to several blocks.
constexpr Index block_rows_least = 512;
constexpr Index block_rows_most = 4096;

class PlateBuilder {
 public:
  PlateBuilder(Index vertex_count, const std::vector<PlateTriangle>& triangles)
      : threads_(setup_threads(triangles.size())),
        patches_(triangles),
        row_count_(vertex_count),
        block_rows_(std::clamp(vertex_count / static_cast<Index>(4 * threads_), block_rows_least,
                               block_rows_most)) {
    if (std::none_of(triangles.begin(), triangles.end(),
                     [](const PlateTriangle& t) { return t.shape != nullptr; }))
      return;
    shape_points_.resize(triangles.size());
    loads_.resize(triangles.size());
  }

  /// Blocks of neighbouring rows are added up one by one, each in the order of triangles and then
  /// of edges: the bits do not depend on the blocks, nor on the threads that take them. Only what
  /// is on the diagonal or to the right of it is added up.
  PlateMatrix build() {
    bulges_ = std::make_unique_for_overwrite<Bulges[]>(at(patches_.size()));
    extent_.resize(at(patches_.size()));
    for_each_index(threads_, at(patches_.size()), [&](std::size_t t) {
      const auto n = static_cast<Index>(t);
      if (patches_.triangle(n).held) return;
      bulges_[t] =
          patches_.quadratic(n, nullptr, patches_.triangle(n).shape ? &shape_points_[t] : nullptr);
      for (const Index v : bulges_[t].vertices)
        extent_[t] = {std::min(extent_[t].first, v), std::max(extent_[t].last, v)};
    });
    list_triangles();
    std::atomic<std::size_t> next{0};
    on_threads(threads_, [&](unsigned) {
      std::vector<std::vector<Entry>> rows(at(block_rows_));
      std::vector<EdgeOf> edges;
      for (std::size_t b = next++; b < blocks_.size(); b = next++) add_up(blocks_[b], rows, edges);
    });
    add_rest_shape();
    PlateMatrix matrix = compressed();
    add_loads(matrix.shape);
    return matrix;
  }

  /// Energy of the first triangles and of the inner edges at them, in place of build(). [J]
  double energy(std::size_t counted, const std::vector<Vec3<double>>& x, PatchNotes* notes) {
    fitted_.assign(at(patches_.size()), false);
    quadratics_ = std::make_unique<Quadratic[]>(at(patches_.size()));
    double sum = 0;
    for (Index t = 0; at(t) < counted; ++t) {
      if (patches_.triangle(t).held) continue;
      PlateNote* note = note_of(t, notes);
      if (note != nullptr && note->weighed) {
        sum += note->energy;
      } else {
        fit(t, notes);
        const double own = triangle_energy(t, x);
        sum += own;
        if (note != nullptr && note->known) {
          note->energy = own;
          note->weighed = true;
        }
      }
      for (int k = 0; k < 3; ++k) {
        const Index other = patches_.neighbour(t, k);
        if (patches_.joins(t, k) && (other > t || at(other) >= counted))
          sum += edge_energy(t, k, x, notes);
      }
    }
    return sum;
  }

 private:
  struct Entry {
    Index column;
    double stiffness;
    double damping;
  };

  /// An inner edge, by the triangle of the lower number.
  struct EdgeOf {
    Index triangle;
    int k;  ///< edge of the triangle
  };

  /// The vertices that the quadratic of a triangle reads are among these; held: none.
  struct Extent {
    Index first = std::numeric_limits<Index>::max();
    Index last = -1;
  };

  /// Neighbouring rows of the matrix, on the diagonal and to the right of it.
  struct Block {
    Index first = 0, last = 0;         ///< rows, without the last
    std::vector<Index> triangles;      ///< whose quadratics read their vertices, ascending
    std::vector<Entry> entries;        ///< row by row, ascending
    std::vector<std::size_t> row_end;  ///< [rows] in the entries

    bool has(Index row) const { return row >= first && row < last; }
    Span<const Entry> row(Index i) const {
      const auto n = at(i - first);
      const std::size_t begin = n == 0 ? 0 : row_end[n - 1];
      return {entries.data() + begin, row_end[n] - begin};
    }
  };

  /// Vertices that two neighbours read: they share two at least.
  static constexpr std::size_t edge_vertices = 2 * quadratic_vertices - 2;
  /// A vertex of some functionals, and its weight in each.
  template <std::size_t N>
  struct Shared {
    Index vertex;
    std::array<double, N> weight;
  };
  /// The vertices of some functionals, ascending.
  template <std::size_t N>
  using Joined = ShortList<Shared<N>, edge_vertices>;

  /// Puts a vertex in its place; these are few.
  /// @return its weights, zero if it was not there
  template <std::size_t N>
  static std::array<double, N>& weights_of(Joined<N>& all, Index v) {
    std::size_t place = all.size();
    while (place > 0 && all[place - 1].vertex > v) --place;
    if (place > 0 && all[place - 1].vertex == v) return all[place - 1].weight;
    all.push_back({v, {}});
    for (std::size_t i = all.size() - 1; i > place; --i) all[i] = all[i - 1];
    all[place] = {v, {}};
    return all[place].weight;
  }

  /// Adds what `term` makes of the weights of every two vertices to the rows of a block.
  /// @param rows [rows of the block]
  template <std::size_t N, class Term>
  static void add(const Joined<N>& all, double damping, const Block& block,
                  std::vector<std::vector<Entry>>& rows, const Term& term) {
    for (std::size_t a = 0; a < all.size(); ++a) {
      const Index i = all[a].vertex;
      if (!block.has(i)) continue;
      std::vector<Entry>& row = rows[at(i - block.first)];
      auto entry = row.begin();
      for (std::size_t b = a; b < all.size(); ++b, ++entry) {
        const Index j = all[b].vertex;
        const double k = term(all[a].weight, all[b].weight);
        while (entry != row.end() && entry->column < j) ++entry;
        if (entry == row.end() || entry->column != j) entry = row.insert(entry, Entry{j, 0, 0});
        entry->stiffness += k;
        entry->damping += damping * k;
      }
    }
  }

  bool reads(Index t, const Block& block) const {
    const Extent& extent = extent_[at(t)];
    if (extent.last < block.first || extent.first >= block.last) return false;
    const auto& vertices = bulges_[at(t)].vertices;
    return std::any_of(vertices.begin(), vertices.end(), [&](Index v) { return block.has(v); });
  }

  /// Makes the blocks, with the triangles of each. Each thread looks at all triangles for its
  /// blocks.
  void list_triangles() {
    blocks_.resize(at((row_count_ + block_rows_ - 1) / block_rows_));
    on_threads(threads_, [&](unsigned thread) {
      const std::size_t begin = blocks_.size() * thread / threads_;
      const std::size_t end = blocks_.size() * (thread + 1) / threads_;
      for (std::size_t b = begin; b < end; ++b) {
        blocks_[b].first = static_cast<Index>(b) * block_rows_;
        blocks_[b].last = std::min(row_count_, blocks_[b].first + block_rows_);
      }
      for (Index t = 0; t < patches_.size(); ++t) {
        const Extent& extent = extent_[at(t)];
        if (extent.last < extent.first) continue;
        const std::size_t first = std::max(begin, at(extent.first / block_rows_));
        const std::size_t last = std::min(end, at(extent.last / block_rows_) + 1);
        if (first >= last) continue;
        for (const Index v : bulges_[at(t)].vertices) {
          const std::size_t b = at(v / block_rows_);
          if (b < first || b >= last) continue;
          std::vector<Index>& triangles = blocks_[b].triangles;
          if (triangles.empty() || triangles.back() != t) triangles.push_back(t);
        }
      }
    });
  }

  /// @param rows  [rows of any block] empty, also afterwards: room for those of the block
  /// @param edges room for those of the block
  void add_up(Block& block, std::vector<std::vector<Entry>>& rows,
              std::vector<EdgeOf>& edges) const {
    for (const Index t : block.triangles) add_triangle(t, block, rows);
    list_edges(block, edges);
    Quadratic q;
    Index of_q = -1;
    for (const EdgeOf& e : edges) {
      if (e.triangle != of_q) patches_.complete(e.triangle, bulges_[at(e.triangle)], q);
      of_q = e.triangle;
      Edge edge(e.triangle, e.k);
      complete(edge, q);
      add_edge(edge, block, rows);
    }
    std::size_t count = 0;
    for (const std::vector<Entry>& row : rows) count += row.size();
    block.entries.reserve(count);
    block.row_end.reserve(at(block.last - block.first));
    for (Index i = block.first; i < block.last; ++i) {
      std::vector<Entry>& row = rows[at(i - block.first)];
      block.entries.insert(block.entries.end(), row.begin(), row.end());
      block.row_end.push_back(block.entries.size());
      row.clear();
    }
    block.triangles = {};
  }

  /// The inner edges at the triangles of a block, ascending.
  void list_edges(const Block& block, std::vector<EdgeOf>& edges) const {
    edges.clear();
    bool ascending = true;
    for (const Index t : block.triangles)
      for (int k = 0; k < 3; ++k) {
        if (!patches_.joins(t, k)) continue;
        const Index other = patches_.neighbour(t, k);
        if (other > t) {
          edges.push_back({t, k});
        } else if (!reads(other, block)) {
          edges.push_back({other, patches_.edge_back(t, k)});
          ascending = false;
        }
      }
    if (ascending) return;
    std::sort(edges.begin(), edges.end(), [](const EdgeOf& a, const EdgeOf& b) {
      return a.triangle != b.triangle ? a.triangle < b.triangle : a.k < b.k;
    });
  }

  /// What is written down about a triangle, or may be; null: nothing. Its neighbours in the patch
  /// have to be those of the mesh: a seam may have some that other patches do not.
  PlateNote* note_of(Index t, PatchNotes* notes) const {
    PlateNote* note = notes != nullptr ? notes->of_triangle[at(t)] : nullptr;
    if (note == nullptr) return nullptr;
    for (int k = 0; k < 3; ++k)
      if (note->inner[static_cast<std::size_t>(k)] != (patches_.neighbour(t, k) >= 0))
        return nullptr;
    return note;
  }

  /// Sees to it that a triangle has its quadratic.
  void fit(Index t, PatchNotes* notes) {
    if (fitted_[at(t)]) return;
    fitted_[at(t)] = true;
    Quadratic& q = quadratics_[at(t)];
    PlateNote* note = note_of(t, notes);
    if (note != nullptr && note->known) {
      q = note->quadratic;
      for (Index& v : q.vertices) v = notes->patch_vertex[at(v)];
      return;
    }
    bool near = false;
    q = patches_.quadratic(t, &near);
    if (note == nullptr || !near) return;
    note->known = true;
    note->quadratic = q;
    for (Index& v : note->quadratic.vertices) v = notes->vertex_of[at(v)];
  }

  /// Of an inner edge. [J]
  double edge_energy(Index t, int k, const std::vector<Vec3<double>>& x, PatchNotes* notes) {
    const Index other = patches_.neighbour(t, k);
    PlateNote* note = note_of(t, notes);
    PlateNote* beyond = note_of(other, notes);
    const auto both_known = [&] {
      return note != nullptr && beyond != nullptr && note->known && beyond->known;
    };
    PlateNote::Edge* known = nullptr;
    if (both_known()) {
      known = &note->edges[static_cast<std::size_t>(k)];
      if (known->other == beyond->triangle && known->version == note->version &&
          known->other_version == beyond->version)
        return known->energy;
    }
    fit(t, notes);
    fit(other, notes);
    Edge edge(t, k);
    complete(edge);
    Vec3<double> jump{}, moment{};
    for (const Shared<2>& s : edge.all) {
      const Vec3<double> from = x[at(s.vertex)] - x[at(patches_.triangle(t).v.v[0])];
      jump += s.weight[0] * from;
      moment += s.weight[1] * from;
    }
    const double energy = edge.cross * dot(jump, moment) + edge.penalty / 2 * length_sq(jump);
    if (both_known()) {
      note->edges[static_cast<std::size_t>(k)] = {beyond->triangle, note->version, beyond->version,
                                                  energy};
      const int back = patches_.edge_back(t, k);
      beyond->edges[static_cast<std::size_t>(back)] = {note->triangle, beyond->version,
                                                       note->version, energy};
    }
    return energy;
  }

  /// @param room for it, of build()
  const Quadratic& quadratic(Index t, Quadratic& room) const {
    if (quadratics_) return quadratics_[at(t)];
    patches_.complete(t, bulges_[at(t)], room);
    return room;
  }

  double triangle_energy(Index t, const std::vector<Vec3<double>>& x) const {
    const Quadratic& q = quadratics_[at(t)];
    Vec3<double> second[3]{};
    for (std::size_t n = 0; n < q.vertices.size(); ++n) {
      const Vec3<double> from = x[at(q.vertices[n])] - x[at(patches_.triangle(t).v.v[0])];
      for (int i = 0; i < 3; ++i) second[i] += q.second[i][n] * from;
    }
    double sum = 0;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        sum += (*patches_.triangle(t).rigidity)(i, j) * dot(second[i], second[j]);
    return patches_.area(t) / 2 * sum;
  }

  void add_triangle(Index t, const Block& block, std::vector<std::vector<Entry>>& rows) const {
    const PlateTriangle& triangle = patches_.triangle(t);
    Quadratic room;
    const Quadratic& q = quadratic(t, room);
    const Mat3<double> d = patches_.area(t) * *triangle.rigidity;
    Joined<3> all;
    for (std::size_t n = 0; n < q.vertices.size(); ++n)
      weights_of(all, q.vertices[n]) = {q.second[0][n], q.second[1][n], q.second[2][n]};
    using Three = std::array<double, 3>;
    add(all, triangle.damping, block, rows, [&](const Three& a, const Three& b) {
      double sum = 0;
      for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j)
          sum += d(static_cast<int>(i), static_cast<int>(j)) * (a[i] * b[j] + a[j] * b[i]);
      return sum / 2;
    });
  }

  /// Adds what rest shapes say, in the order of triangles and edges.
  void add_rest_shape() {
    if (loads_.empty()) return;
    for (Index t = 0; t < patches_.size(); ++t)
      if (patches_.triangle(t).shape != nullptr) load_triangle(t);
    constexpr Index at_once = 1 << 15;
    std::vector<Edge> edges;
    for (Index first = 0; first < patches_.size(); first += at_once) {
      edges.clear();
      for (Index t = first; t < std::min(patches_.size(), first + at_once); ++t)
        for (int k = 0; k < 3; ++k) {
          const Index other = patches_.neighbour(t, k);
          if (other > t && patches_.joins(t, k) &&
              (patches_.triangle(t).shape != nullptr || patches_.triangle(other).shape != nullptr))
            edges.emplace_back(t, k);
        }
      for_each_index(threads_, edges.size(), [&](std::size_t e) { complete(edges[e]); });
      for (const Edge& edge : edges) load_edge(edge);
    }
  }

  void load_triangle(Index t) {
    Quadratic room;
    const Quadratic& q = quadratic(t, room);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        const double k = patches_.area(t) * (*patches_.triangle(t).rigidity)(i, j);
        if (k == 0) continue;
        const Vec3<double> there = at_rest(t, q.vertices, q.second[j]);
        add_load(t, q.vertices, q.second[i], k * there);
        shape_energy_ += k / 2 * dot(at_rest(t, q.vertices, q.second[i]), there);
      }
  }

  /// A functional of a triangle's rest shape, without what it would lose to the shape's place.
  /// @param vertices that its quadratic reads
  template <class Vertices, class Values>
  Vec3<double> at_rest(Index t, const Vertices& vertices, const Values& weight) const {
    const PlateTriangle& triangle = patches_.triangle(t);
    const std::array<Vec3<double>, 3>& shape = *triangle.shape;
    Quadratic room;
    const Quadratic& q = quadratic(t, room);
    Vec3<double> sum{};
    for (std::size_t n = 0; n < vertices.size(); ++n) {
      const auto corner = static_cast<std::size_t>(
          std::find(triangle.v.v, triangle.v.v + 3, vertices[n]) - triangle.v.v);
      const auto read = static_cast<std::size_t>(
          std::find(q.vertices.begin(), q.vertices.end(), vertices[n]) - q.vertices.begin());
      sum += weight[n] * ((corner < 3 ? shape[corner] : shape_points_[at(t)][read]) - shape[0]);
    }
    return sum;
  }

  template <class Vertices, class Values>
  void add_load(Index t, const Vertices& vertices, const Values& weight,
                const Vec3<double>& force) {
    std::vector<std::pair<Index, Vec3<double>>>& load = loads_[at(t)];
    for (std::size_t n = 0; n < vertices.size(); ++n) {
      const auto found = std::find_if(load.begin(), load.end(),
                                      [v = vertices[n]](const auto& l) { return l.first == v; });
      Vec3<double>& sum = found == load.end()
                              ? load.emplace_back(vertices[n], Vec3<double>{}).second
                              : found->second;
      sum += weight[n] * force;
    }
  }

  void add_loads(PlateShape& shape) {
    for (std::size_t t = 0; t < loads_.size(); ++t) {
      if (loads_[t].empty()) continue;
      std::sort(loads_[t].begin(), loads_[t].end(),
                [](const auto& a, const auto& b) { return a.first < b.first; });
      const PlateTriangle& triangle = patches_.triangle(static_cast<Index>(t));
      const Vec2<double> a = triangle.rest[1] - triangle.rest[0];
      const Vec2<double> b = triangle.rest[2] - triangle.rest[0];
      const double det = a[0] * b[1] - a[1] * b[0];
      const Mat2<double> inv_rest{{b[1] / det, -b[0] / det, -a[1] / det, a[0] / det}};
      const TriangleFrame<double> frame = triangle_frame(triangle.shape->data(), inv_rest);
      if (shape.offset.empty()) shape.offset.push_back(0);
      shape.corners.push_back(triangle.v);
      shape.inv_rest.push_back(inv_rest);
      for (const auto& [v, force] : loads_[t]) {
        shape.vertex.push_back(v);
        shape.force.push_back(
            {dot(frame.axis[0], force), dot(frame.axis[1], force), dot(frame.axis[2], force)});
      }
      shape.offset.push_back(static_cast<Offset>(shape.vertex.size()));
    }
    shape.energy = shape_energy_;
  }

  /// What one of its triangles says of an edge.
  struct EdgeSide {
    ShortList<Index, quadratic_vertices> vertices;  ///< the corners, then others
    Weights slope{};                                ///< outwards, at the middle of the edge
    Weights moment{};                               ///< [N m] across the edge
    double length;                                  ///< [m]
    double penalty;                                 ///< [N m / m^2] n D_n / A
  };

  EdgeSide edge_side(Index t, int k) const {
    Quadratic room;
    return edge_side(t, k, quadratic(t, room));
  }

  EdgeSide edge_side(Index t, int k, const Quadratic& q) const {
    const PlateTriangle& triangle = patches_.triangle(t);
    const int a = (k + 1) % 3;
    const int b = (k + 2) % 3;
    const Point e = patches_.rest(t, b) - patches_.rest(t, a);
    EdgeSide side;
    side.length = e.norm();
    const Point n = Point(e.y(), -e.x()) / side.length;
    for (std::size_t i = 0; i < 3; ++i) {
      side.vertices.push_back(triangle.v.v[i]);
      side.slope[i] = n.dot(q.gradient[i]);
    }
    // Of lambda_a lambda_b in the middle, and of the two products that vanish along the edge.
    const double middle = n.dot(q.gradient[a] + q.gradient[b]) / 2;
    const double other = n.dot(q.gradient[k]) / 2;
    const Vec3<double> across{n.x() * n.x(), n.y() * n.y(), n.x() * n.y()};
    const Vec3<double> moment = *triangle.rigidity * across;
    for (std::size_t v = 0; v < q.vertices.size(); ++v) {
      const auto place = static_cast<std::size_t>(
          std::find(side.vertices.begin(), side.vertices.end(), q.vertices[v]) -
          side.vertices.begin());
      if (place == side.vertices.size()) side.vertices.push_back(q.vertices[v]);
      side.slope[place] += middle * q.bulge[k][v];
      side.slope[place] += other * q.bulge[a][v];
      side.slope[place] += other * q.bulge[b][v];
      for (int i = 0; i < 3; ++i) side.moment[place] += moment[i] * q.second[i][v];
    }
    int inner = 0;
    for (int edge = 0; edge < 3; ++edge) inner += patches_.joins(t, edge) ? 1 : 0;
    side.penalty = inner * dot(across, moment) / patches_.area(t);
    return side;
  }

  /// An inner edge and its terms.
  struct Edge {
    Edge(Index t, int edge) : triangle(t), k(edge) {}
    Index triangle;
    int k;  ///< edge of the triangle
    Index other = 0;
    Joined<2> all;       ///< jump of the slope, and [N m] sum of the moments of both sides
    double cross = 0;    ///< [m]
    double penalty = 0;  ///< [N m]
    double damping = 0;  ///< [s]
  };

  void complete(Edge& edge) const {
    Quadratic room;
    complete(edge, quadratic(edge.triangle, room));
  }

  /// @param q of its triangle
  void complete(Edge& edge, const Quadratic& q) const {
    const Index t = edge.triangle;
    edge.other = patches_.neighbour(t, edge.k);
    const EdgeSide side = edge_side(t, edge.k, q);
    const EdgeSide opposite = edge_side(edge.other, patches_.edge_back(t, edge.k));
    for (const EdgeSide* s : {&side, &opposite})
      for (std::size_t n = 0; n < s->vertices.size(); ++n) {
        std::array<double, 2>& weight = weights_of(edge.all, s->vertices[n]);
        weight[0] += s->slope[n];
        weight[1] += s->moment[n];
      }
    // Sides that are sewn together need not be of one length.
    const double length = (side.length + opposite.length) / 2;
    edge.damping = (patches_.triangle(t).damping + patches_.triangle(edge.other).damping) / 2;
    edge.cross = -length / 2;
    edge.penalty = length * length / 4 * (side.penalty + opposite.penalty);
  }

  static void add_edge(const Edge& e, const Block& block, std::vector<std::vector<Entry>>& rows) {
    using Two = std::array<double, 2>;  // in the jump, in the moment
    add(e.all, e.damping, block, rows, [&](const Two& a, const Two& b) {
      return e.cross * (a[0] * b[1] + a[1] * b[0]) + e.penalty * a[0] * b[0];
    });
  }

  /// A functional of what the sides of an edge read.
  struct EdgeLoad {
    ShortList<Index, edge_vertices> vertices;
    std::array<double, edge_vertices> weight;

    /// @param n which of the two that Edge::all has
    void add(const Edge& e, const ShortList<Index, quadratic_vertices>& side, std::size_t n) {
      for (const Index v : side) {
        if (std::find(vertices.begin(), vertices.end(), v) != vertices.end()) continue;
        for (const Shared<2>& s : e.all)
          if (s.vertex == v) weight[vertices.size()] = s.weight[n];
        vertices.push_back(v);
      }
    }
  };

  void load_edge(const Edge& e) {
    const std::array<Index, 2> half{e.triangle, e.other};
    const std::array<int, 2> k{e.k, patches_.edge_back(e.triangle, e.k)};
    const bool shaped[2] = {patches_.triangle(half[0]).shape != nullptr,
                            patches_.triangle(half[1]).shape != nullptr};
    if (!shaped[0] && !shaped[1]) return;
    const EdgeSide side[2] = {edge_side(half[0], k[0]), edge_side(half[1], k[1])};
    EdgeLoad jump, moment;
    for (const EdgeSide& s : side) jump.add(e, s.vertices, 0);
    for (const Index t : half) moment.add(e, bulges_[at(t)].vertices, 1);
    Vec3<double> slope_there[2]{}, moment_there[2]{};
    for (int n = 0; n < 2; ++n) {
      if (!shaped[n]) continue;
      slope_there[n] = at_rest(half[n], side[n].vertices, side[n].slope);
      moment_there[n] = at_rest(half[n], side[n].vertices, side[n].moment);
    }
    const bool both = shaped[0] && shaped[1];
    const double share = both ? 0.5 : 1;
    for (std::size_t n = 0; n < 2; ++n) {
      if (!shaped[n]) continue;
      Vec3<double> jump_at_rest = slope_there[n];
      Vec3<double> moment_at_rest = moment_there[n];
      if (both) {
        const auto there = [&](const Vec3<double>& v) {
          return patches_.same_piece(half[n], k[n])
                     ? v
                     : turned(v, edge_axes(half[1 - n], k[1 - n], -1), edge_axes(half[n], k[n], 1));
        };
        jump_at_rest += there(slope_there[1 - n]);
        moment_at_rest += there(moment_there[1 - n]);
      } else {
        // The flat neighbour goes on in the plane of the triangle.
        const Vec3<double> normal = edge_axes(half[n], k[n], 1)[2];
        jump_at_rest = dot(normal, jump_at_rest) * normal;
      }
      add_load(half[n], jump.vertices, jump.weight,
               share * (e.cross * moment_at_rest + e.penalty * jump_at_rest));
      add_load(half[n], moment.vertices, moment.weight, share * e.cross * jump_at_rest);
      shape_energy_ += share * (e.cross * dot(jump_at_rest, moment_at_rest) +
                                e.penalty / 2 * dot(jump_at_rest, jump_at_rest));
    }
  }

  using Axes = std::array<Vec3<double>, 3>;

  /// Directions in the rest shape of a triangle: along its edge, in its plane across that, and its
  /// normal.
  /// @param sign -1: against the edge
  Axes edge_axes(Index t, int k, double sign) const {
    const std::array<Vec3<double>, 3>& y = *patches_.triangle(t).shape;
    const Vec3<double> edge =
        y[static_cast<std::size_t>((k + 2) % 3)] - y[static_cast<std::size_t>((k + 1) % 3)];
    const Vec3<double> area = cross(y[1] - y[0], y[2] - y[0]);
    const Vec3<double> along = (sign / length(edge)) * edge;
    const Vec3<double> normal = (1 / length(area)) * area;
    return {along, cross(normal, along), normal};
  }

  static Vec3<double> turned(const Vec3<double>& v, const Axes& from, const Axes& to) {
    return dot(from[0], v) * to[0] + dot(from[1], v) * to[1] + dot(from[2], v) * to[2];
  }

  /// The whole matrix: rows from the upper half, without what rounding leaves.
  PlateMatrix compressed() {
    drop_negligible();
    PlateMatrix m;
    m.row_offset.assign(at(row_count_) + 1, 0);
    for_own_entries([&](Index row, Index, const Entry&) { ++m.row_offset[at(row) + 1]; });
    for (std::size_t i = 0; i < at(row_count_); ++i) m.row_offset[i + 1] += m.row_offset[i];
    const auto entries = static_cast<std::size_t>(m.row_offset.back());
    // The time goes into memory that is touched for the first time.
    for_each_index(std::min(threads_, 2u), 2, [&](std::size_t n) {
      (n == 0 ? m.stiffness : m.damping).resize(entries);
      if (n == 0) m.column.resize(entries);
    });
    std::vector<Offset> next(m.row_offset.begin(), m.row_offset.end() - 1);
    for_own_entries([&](Index row, Index column, const Entry& e) {
      const auto place = static_cast<std::size_t>(next[at(row)]++);
      m.column[place] = column;
      m.stiffness[place] = e.stiffness;
      m.damping[place] = e.damping;
    });
    return m;
  }

  void drop_negligible() {
    std::vector<double> diagonal(at(row_count_), 0);
    for (const Block& block : blocks_)
      for (Index i = block.first; i < block.last; ++i)
        if (!block.row(i).empty()) diagonal[at(i)] = block.row(i)[0].stiffness;
    for_each_index(threads_, blocks_.size(), [&](std::size_t b) {
      Block& block = blocks_[b];
      std::size_t kept = 0, begin = 0;
      for (Index i = block.first; i < block.last; ++i) {
        std::size_t& end = block.row_end[at(i - block.first)];
        for (std::size_t n = begin; n < end; ++n) {
          const Entry& e = block.entries[n];
          const double least = negligible * std::sqrt(diagonal[at(i)] * diagonal[at(e.column)]);
          if (!(std::abs(e.stiffness) <= least)) block.entries[kept++] = e;
        }
        begin = std::exchange(end, kept);
      }
    });
  }

  /// Calls use(row, column, entry) for each entry of the whole matrix, the columns of a row in
  /// ascending order: those left of its diagonal are of rows above. Each thread has rows of its
  /// own, and looks through the rows above these for what reaches them.
  template <class Use>
  void for_own_entries(const Use& use) const {
    on_threads(threads_, [&](unsigned thread) {
      const std::size_t end = blocks_.size() * (thread + 1) / threads_;
      const std::size_t begin = blocks_.size() * thread / threads_;
      if (begin == end) return;
      const Index first = blocks_[begin].first, last = blocks_[end - 1].last;
      for (std::size_t b = 0; b < end; ++b)
        for (Index i = blocks_[b].first; i < blocks_[b].last; ++i) {
          const Span<const Entry> row = blocks_[b].row(i);
          if (row.empty() || row[row.size() - 1].column < first) continue;
          for (const Entry& e : row) {
            if (i >= first) use(i, e.column, e);
            if (e.column != i && e.column >= first && e.column < last) use(e.column, i, e);
          }
        }
    });
  }

  unsigned threads_;
  PlatePatches patches_;
  Index row_count_;
  Index block_rows_;
  std::unique_ptr<Quadratic[]> quadratics_;  ///< [triangles] of energy()
  std::unique_ptr<Bulges[]> bulges_;         ///< [triangles] of build(); held: empty
  std::vector<Extent> extent_;               ///< [triangles] of build()
  std::vector<bool> fitted_;                 ///< of energy(): which have their quadratics
  std::vector<Block> blocks_;                ///< of build(), ascending
  std::vector<ShapePoints>
      shape_points_;  ///< [triangles] of their quadratics; none are shaped: empty
  std::vector<std::vector<std::pair<Index, Vec3<double>>>> loads_;  ///< [triangles] of PlateShape
  double shape_energy_ = 0;                                         ///< [J] of PlateShape
};

}  // namespace

PlateMatrix make_plate_matrix(Index vertex_count, const std::vector<PlateTriangle>& triangles) {
  return PlateBuilder(vertex_count, triangles).build();
}

double plate_energy(const std::vector<PlateTriangle>& triangles, std::size_t counted,
                    const std::vector<Vec3<double>>& positions, PatchNotes* notes) {
  return PlateBuilder(0, triangles).energy(counted, positions, notes);
}

double plate_energy(const PlateMatrix& matrix, const std::vector<Vec3<double>>& positions) {
  // Rows sum to zero, so differences say the same, and say it more exactly.
  const std::size_t rows = matrix.row_offset.empty() ? 0 : matrix.row_offset.size() - 1;
  double sum = sum_of(rows, [&](std::size_t i) {
    double of_row = 0;
    for (auto e = static_cast<std::size_t>(matrix.row_offset[i]);
         e < static_cast<std::size_t>(matrix.row_offset[i + 1]); ++e)
      of_row -= matrix.stiffness[e] * length_sq(positions[at(matrix.column[e])] - positions[i]) / 4;
    return of_row;
  });
  const PlateShape& shape = matrix.shape;
  sum += sum_of(shape.corners.size(), [&](std::size_t t) {
    Vec3<double> x[3];
    for (int j = 0; j < 3; ++j) x[j] = positions[at(shape.corners[t].v[j])];
    const TriangleFrame<double> frame = triangle_frame(x, shape.inv_rest[t]);
    double of_triangle = 0;
    for (auto e = static_cast<std::size_t>(shape.offset[t]);
         e < static_cast<std::size_t>(shape.offset[t + 1]); ++e)
      of_triangle -= dot(positions[at(shape.vertex[e])] - x[0], from_frame(frame, shape.force[e]));
    return of_triangle;
  });
  return sum + shape.energy;
}

}  // namespace weft
