#include "host/model/plate.hpp"

#include <Eigen/Dense>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "host/base/parallel.hpp"
#include "host/model/plate_notes.hpp"
#include "host/model/plate_patch.hpp"
#include "weft/core/at.hpp"
#include "weft/elements/triangle_frame.hpp"

namespace weft {
namespace {

using Point = PlatePatches::Point;

/// Entries below this share of their diagonals are what rounding leaves of a zero.
constexpr double negligible = 1e-12;
/// Most rows have fewer entries on the diagonal and to the right of it.
constexpr std::size_t usual_row = 16;

class PlateBuilder {
 public:
  PlateBuilder(Index vertex_count, const std::vector<PlateTriangle>& triangles)
      : threads_(setup_threads(triangles.size())),
        patches_(triangles),
        quadratics_(triangles.size()),
        rows_(at(vertex_count)) {
    if (std::none_of(triangles.begin(), triangles.end(),
                     [](const PlateTriangle& t) { return t.shaped; }))
      return;
    shape_points_.resize(triangles.size());
    loads_.resize(triangles.size());
  }

  /// Each thread has rows of its own, and adds to these in the order of triangles and edges. Only
  /// what is on the diagonal or to the right of it is added up.
  PlateMatrix build() {
    for_each_index(threads_, quadratics_.size(), [&](std::size_t t) {
      const auto n = static_cast<Index>(t);
      if (!patches_.triangle(n).held)
        quadratics_[t] = patches_.quadratic(
            n, nullptr, patches_.triangle(n).shaped ? &shape_points_[t] : nullptr);
    });
    on_threads(threads_, [&](unsigned thread) {
      for (Index t = 0; t < patches_.size(); ++t) add_triangle(t, thread);
    });
    for (Index t = 0; t < patches_.size(); ++t)
      if (patches_.triangle(t).shaped) load_triangle(t);
    // As many as fit into a cache, or as are worth starting threads for.
    const Index at_once = threads_ == 1 ? 1 << 8 : 1 << 15;
    std::vector<Edge> edges;
    for (Index first = 0; first < patches_.size(); first += at_once) {
      edges.clear();
      for (Index t = first; t < std::min(patches_.size(), first + at_once); ++t)
        for (int k = 0; k < 3; ++k)
          if (patches_.neighbour(t, k) > t && patches_.joins(t, k)) edges.emplace_back(t, k);
      for_each_index(threads_, edges.size(), [&](std::size_t e) { complete(edges[e]); });
      on_threads(threads_, [&](unsigned thread) {
        for (const Edge& edge : edges) add_edge(edge, thread);
      });
      for (const Edge& edge : edges) load_edge(edge);
    }
    PlateMatrix matrix = compressed();
    add_loads(matrix.shape);
    return matrix;
  }

  /// Energy of the first triangles and of the inner edges at them, in place of build(). [J]
  double energy(std::size_t counted, const std::vector<Vec3<double>>& x, PatchNotes* notes) {
    fitted_.assign(quadratics_.size(), false);
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

  /// Adds what `term` makes of the weights of every two vertices to the thread's rows.
  template <std::size_t N, class Term>
  void add(const Joined<N>& all, double damping, unsigned thread, const Term& term) {
    for (std::size_t a = 0; a < all.size(); ++a) {
      const Index i = all[a].vertex;
      if (((static_cast<unsigned>(i) >> 6) & (threads_ - 1)) != thread) continue;
      std::vector<Entry>& row = rows_[at(i)];
      if (row.empty()) row.reserve(usual_row);
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
        sum += patches_.triangle(t).rigidity(i, j) * dot(second[i], second[j]);
    return patches_.area(t) / 2 * sum;
  }

  void add_triangle(Index t, unsigned thread) {
    const PlateTriangle& triangle = patches_.triangle(t);
    const Quadratic& q = quadratics_[at(t)];
    const Mat3<double> d = patches_.area(t) * triangle.rigidity;
    Joined<3> all;
    for (std::size_t n = 0; n < q.vertices.size(); ++n)
      weights_of(all, q.vertices[n]) = {q.second[0][n], q.second[1][n], q.second[2][n]};
    using Three = std::array<double, 3>;
    add(all, triangle.damping, thread, [&](const Three& a, const Three& b) {
      double sum = 0;
      for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j)
          sum += d(static_cast<int>(i), static_cast<int>(j)) * (a[i] * b[j] + a[j] * b[i]);
      return sum / 2;
    });
  }

  void load_triangle(Index t) {
    const Quadratic& q = quadratics_[at(t)];
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        const double k = patches_.area(t) * patches_.triangle(t).rigidity(i, j);
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
    const Vec3<double>& base = triangle.shape[0];
    const Quadratic& q = quadratics_[at(t)];
    Vec3<double> sum{};
    for (std::size_t n = 0; n < vertices.size(); ++n) {
      const auto corner = static_cast<std::size_t>(
          std::find(triangle.v.v, triangle.v.v + 3, vertices[n]) - triangle.v.v);
      const auto read = static_cast<std::size_t>(
          std::find(q.vertices.begin(), q.vertices.end(), vertices[n]) - q.vertices.begin());
      sum +=
          weight[n] * ((corner < 3 ? triangle.shape[corner] : shape_points_[at(t)][read]) - base);
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
      const TriangleFrame<double> frame = triangle_frame(triangle.shape.data(), inv_rest);
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
    const Quadratic& q = quadratics_[at(t)];
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
    const Vec3<double> moment = triangle.rigidity * across;
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
    const Index t = edge.triangle;
    edge.other = patches_.neighbour(t, edge.k);
    const EdgeSide side = edge_side(t, edge.k);
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

  void add_edge(const Edge& e, unsigned thread) {
    using Two = std::array<double, 2>;  // in the jump, in the moment
    add(e.all, e.damping, thread, [&](const Two& a, const Two& b) {
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
    const bool shaped[2] = {patches_.triangle(half[0]).shaped, patches_.triangle(half[1]).shaped};
    if (!shaped[0] && !shaped[1]) return;
    const EdgeSide side[2] = {edge_side(half[0], k[0]), edge_side(half[1], k[1])};
    EdgeLoad jump, moment;
    for (const EdgeSide& s : side) jump.add(e, s.vertices, 0);
    for (const Index t : half) moment.add(e, quadratics_[at(t)].vertices, 1);
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
    const std::array<Vec3<double>, 3>& y = patches_.triangle(t).shape;
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
    const std::size_t count = rows_.size();
    std::vector<double> diagonal(count, 0);
    for_each_index(threads_, count, [&](std::size_t i) {
      if (!rows_[i].empty()) diagonal[i] = rows_[i].front().stiffness;
    });
    PlateMatrix m;
    m.row_offset.assign(count + 1, 0);
    for_each_index(threads_, count, [&](std::size_t i) {
      std::erase_if(rows_[i], [&](const Entry& e) {
        return std::abs(e.stiffness) <=
               negligible * std::sqrt(diagonal[i] * diagonal[at(e.column)]);
      });
    });
    for (std::size_t i = 0; i < count; ++i)
      for (const Entry& e : rows_[i]) {
        ++m.row_offset[i + 1];
        if (at(e.column) != i) ++m.row_offset[at(e.column) + 1];
      }
    for (std::size_t i = 0; i < count; ++i) m.row_offset[i + 1] += m.row_offset[i];
    std::vector<Offset> next(m.row_offset.begin(), m.row_offset.end() - 1);
    m.column.resize(static_cast<std::size_t>(m.row_offset.back()));
    m.stiffness.resize(m.column.size());
    m.damping.resize(m.column.size());
    const auto put = [&](std::size_t row, Index column, const Entry& e) {
      const auto place = static_cast<std::size_t>(next[row]++);
      m.column[place] = column;
      m.stiffness[place] = e.stiffness;
      m.damping[place] = e.damping;
    };
    // A row's entries left of the diagonal are those of rows above, which have been put by then.
    for (std::size_t i = 0; i < count; ++i) {
      for (const Entry& e : rows_[i]) {
        put(i, e.column, e);
        if (at(e.column) != i) put(at(e.column), static_cast<Index>(i), e);
      }
      rows_[i] = {};
    }
    return m;
  }

  unsigned threads_;
  PlatePatches patches_;
  std::vector<Quadratic> quadratics_;     ///< of held triangles: empty
  std::vector<bool> fitted_;              ///< of energy(): which have theirs
  std::vector<std::vector<Entry>> rows_;  ///< ascending
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
