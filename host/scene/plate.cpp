#include "host/scene/plate.hpp"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>

#include "host/scene/plate_patch.hpp"

namespace weft {
namespace {

using Point = PlatePatches::Point;

/// Entries below this share of their diagonals are what rounding leaves of a zero.
constexpr double negligible = 1e-12;

std::size_t at(Index i) {
  return static_cast<std::size_t>(i);
}

class PlateBuilder {
 public:
  PlateBuilder(Index vertex_count, const std::vector<PlateTriangle>& triangles)
      : patches_(triangles), rows_(at(vertex_count)) {
    for (Index t = 0; t < patches_.size(); ++t)
      quadratics_.push_back(patches_.triangle(t).held ? Quadratic{} : patches_.quadratic(t));
  }

  PlateMatrix build() {
    for (Index t = 0; t < patches_.size(); ++t) add_triangle(t);
    for (Index t = 0; t < patches_.size(); ++t)
      for (int k = 0; k < 3; ++k)
        if (patches_.neighbour(t, k) > t && patches_.joins(t, k)) add_edge(t, k);
    return compressed();
  }

 private:
  struct Entry {
    Index column;
    double stiffness;
    double damping;
  };

  /// Energy and damping of a sum of products of functionals.
  void add(const Functional& a, const Functional& b, double stiffness, double damping) {
    for (const auto& [i, wa] : a.terms)
      for (const auto& [j, wb] : b.terms) {
        const double share = wa * wb;
        std::vector<Entry>& row = rows_[at(i)];
        const auto found = std::find_if(
            row.begin(), row.end(), [&, column = j](const Entry& e) { return e.column == column; });
        Entry& entry = found == row.end() ? row.emplace_back(Entry{j, 0, 0}) : *found;
        entry.stiffness += stiffness * share;
        entry.damping += damping * share;
      }
  }

  void add_triangle(Index t) {
    const PlateTriangle& triangle = patches_.triangle(t);
    const Quadratic& q = quadratics_[at(t)];
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        const double k = patches_.area(t) * triangle.rigidity(i, j);
        if (k != 0) add(q.second[i], q.second[j], k, triangle.damping * k);
      }
  }

  struct EdgeSide {
    Functional slope;   ///< outwards, at the middle of the edge
    Functional moment;  ///< [N m] across the edge
    double length;      ///< [m]
    double penalty;     ///< [N m / m^2] n D_n / A
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
    for (int i = 0; i < 3; ++i) side.slope.add(triangle.v.v[i], n.dot(q.gradient[i]));
    // Of lambda_a lambda_b in the middle, and of the two products that vanish along the edge.
    side.slope.add(q.bulge[k], n.dot(q.gradient[a] + q.gradient[b]) / 2);
    side.slope.add(q.bulge[a], n.dot(q.gradient[k]) / 2);
    side.slope.add(q.bulge[b], n.dot(q.gradient[k]) / 2);
    const Vec3<double> across{n.x() * n.x(), n.y() * n.y(), n.x() * n.y()};
    const Vec3<double> moment = triangle.rigidity * across;
    for (int i = 0; i < 3; ++i) side.moment.add(q.second[i], moment[i]);
    int inner = 0;
    for (int edge = 0; edge < 3; ++edge) inner += patches_.joins(t, edge) ? 1 : 0;
    side.penalty = inner * dot(across, moment) / patches_.area(t);
    return side;
  }

  void add_edge(Index t, int k) {
    const Index other = patches_.neighbour(t, k);
    EdgeSide side = edge_side(t, k);
    const EdgeSide opposite = edge_side(other, patches_.edge_back(t, k));
    side.slope.add(opposite.slope, 1);
    side.moment.add(opposite.moment, 1);
    // Sides that are sewn together need not be of one length.
    const double length = (side.length + opposite.length) / 2;
    const double damping = (patches_.triangle(t).damping + patches_.triangle(other).damping) / 2;
    const double cross_term = -length / 2;
    add(side.slope, side.moment, cross_term, damping * cross_term);
    add(side.moment, side.slope, cross_term, damping * cross_term);
    const double penalty = length * length / 4 * (side.penalty + opposite.penalty);
    add(side.slope, side.slope, penalty, damping * penalty);
  }

  PlateMatrix compressed() {
    std::vector<double> diagonal(rows_.size(), 0);
    for (std::size_t i = 0; i < rows_.size(); ++i)
      for (const Entry& e : rows_[i])
        if (at(e.column) == i) diagonal[i] = e.stiffness;
    for (std::vector<Entry>& row : rows_)
      std::sort(row.begin(), row.end(),
                [](const Entry& a, const Entry& b) { return a.column < b.column; });
    // Symmetric to the bit: rounding depends on the order in which terms came.
    for (std::size_t i = 0; i < rows_.size(); ++i)
      for (Entry& e : rows_[i]) {
        if (at(e.column) <= i) continue;
        std::vector<Entry>& other = rows_[at(e.column)];
        const auto mirror =
            std::lower_bound(other.begin(), other.end(), static_cast<Index>(i),
                             [](const Entry& a, Index column) { return a.column < column; });
        e.stiffness = mirror->stiffness = (e.stiffness + mirror->stiffness) / 2;
        e.damping = mirror->damping = (e.damping + mirror->damping) / 2;
      }
    PlateMatrix m;
    m.row_offset.push_back(0);
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      std::vector<Entry>& row = rows_[i];
      for (const Entry& e : row) {
        if (std::abs(e.stiffness) <= negligible * std::sqrt(diagonal[i] * diagonal[at(e.column)]))
          continue;
        m.column.push_back(e.column);
        m.stiffness.push_back(e.stiffness);
        m.damping.push_back(e.damping);
      }
      m.row_offset.push_back(static_cast<Offset>(m.column.size()));
      row = {};
    }
    return m;
  }

  PlatePatches patches_;
  std::vector<Quadratic> quadratics_;  ///< of held triangles: empty
  std::vector<std::vector<Entry>> rows_;
};

}  // namespace

PlateMatrix make_plate_matrix(Index vertex_count, const std::vector<PlateTriangle>& triangles) {
  return PlateBuilder(vertex_count, triangles).build();
}

double plate_energy(const PlateMatrix& matrix, const std::vector<Vec3<double>>& positions) {
  // Rows sum to zero, so differences say the same, and say it more exactly.
  double sum = 0;
  for (std::size_t i = 0; i + 1 < matrix.row_offset.size(); ++i)
    for (auto e = static_cast<std::size_t>(matrix.row_offset[i]);
         e < static_cast<std::size_t>(matrix.row_offset[i + 1]); ++e)
      sum -= matrix.stiffness[e] * length_sq(positions[at(matrix.column[e])] - positions[i]) / 4;
  return sum;
}

}  // namespace weft
