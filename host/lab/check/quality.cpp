#include "host/lab/check/quality.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <cmath>

namespace weft::lab {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

constexpr double smallest_aspect = 1e-10;

template <int N>
bool finite(const Vec<double, N>& x) {
  bool r = true;
  for (int k = 0; k < N; ++k) r = r && std::isfinite(x[k]);
  return r;
}

void add(Findings& findings, std::size_t number, std::size_t limit) {
  if (findings.list.size() < limit) findings.list.push_back(static_cast<Index>(number));
  ++findings.count;
}

/// A value an element of the three corners of a triangle.
template <class T>
std::array<T, 3> corners(const std::vector<T>& values, const Tri& t) {
  return {values[static_cast<std::size_t>(t.v[0])], values[static_cast<std::size_t>(t.v[1])],
          values[static_cast<std::size_t>(t.v[2])]};
}

bool has_zero_area(const std::array<Vec3<double>, 3>& x) {
  const auto point = [](const Vec3<double>& p) { return Kernel::Point_3(p[0], p[1], p[2]); };
  return CGAL::collinear(point(x[0]), point(x[1]), point(x[2]));
}

/// 2 area / longest edge squared, rounded; 0 where all the corners coincide.
double aspect(const std::array<Vec3<double>, 3>& x) {
  std::array<Vec3<double>, 3> edges{x[1] - x[0], x[2] - x[1], x[0] - x[2]};
  double scale = 0;
  for (const auto& e : edges)
    for (int k = 0; k < 3; ++k) scale = std::max(scale, std::fabs(e[k]));
  if (!(scale > 0)) return 0;
  double longest_sq = 0;
  // Divided, not multiplied by the inverse: that one overflows for the smallest lengths.
  for (auto& e : edges) {
    for (int k = 0; k < 3; ++k) e[k] /= scale;
    longest_sq = std::max(longest_sq, length_sq(e));
  }
  return length(cross(edges[0], edges[1])) / longest_sq;
}

/// Exact sign of the signed area in the plane; 0 for collinear corners.
int orientation(const std::array<Vec2<double>, 3>& m) {
  const auto point = [](const Vec2<double>& p) { return Kernel::Point_2(p[0], p[1]); };
  return static_cast<int>(CGAL::orientation(point(m[0]), point(m[1]), point(m[2])));
}

/// Both principal stretches, the larger one first.
/// @return false where they cannot be computed in double precision
bool principal_stretches(const std::array<Vec3<double>, 3>& x, const std::array<Vec2<double>, 3>& m,
                         double& largest, double& smallest) {
  const Vec2<double> d1 = m[1] - m[0], d2 = m[2] - m[0];
  const double det = d1[0] * d2[1] - d1[1] * d2[0];
  const Vec3<double> e1 = x[1] - x[0], e2 = x[2] - x[0];
  const Vec3<double> f0 = (e1 * d2[1] - e2 * d1[1]) * (1 / det);
  const Vec3<double> f1 = (e2 * d1[0] - e1 * d2[0]) * (1 / det);
  const double a = length_sq(f0), b = dot(f0, f1), c = length_sq(f1);
  largest = std::sqrt(0.5 * (a + c + std::hypot(a - c, 2 * b)));
  // From the area ratio, not from the other root: that one cancels when the sheet is crushed.
  smallest = largest > 0 ? length(cross(f0, f1)) / largest : 0;
  return std::isfinite(largest) && std::isfinite(smallest);
}

Percentiles percentiles(std::vector<double>& values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const auto rank = [&](std::size_t percent) {
    return values[(percent * values.size() + 99) / 100 - 1];
  };
  return {values.front(), rank(1), rank(50), rank(99), values.back()};
}

/// Corners of a triangle in material space.
std::array<Vec2<double>, 3> material_corners(const Mesh& mesh, Index triangle) {
  const auto& own = mesh.material_triangles.empty() ? mesh.triangles : mesh.material_triangles;
  return corners(mesh.material, own[static_cast<std::size_t>(triangle)]);
}

bool has_finite_material(const std::array<Vec2<double>, 3>& m) {
  return finite(m[0]) && finite(m[1]) && finite(m[2]);
}

}  // namespace

Findings nonfinite_vertices(const std::vector<Vec3<double>>& positions,
                            const std::vector<Vec2<double>>& material, std::size_t limit) {
  Findings findings;
  for (std::size_t i = 0; i < positions.size(); ++i)
    if (!finite(positions[i]) || (!material.empty() && !finite(material[i])))
      add(findings, i, limit);
  return findings;
}

Findings degenerate_triangles(const Mesh& mesh, const std::vector<Index>& ids, std::size_t limit) {
  Findings findings;
  for (const Index i : ids) {
    const auto x = corners(mesh.positions, mesh.triangles[static_cast<std::size_t>(i)]);
    // Rounding moves the aspect by some 1e-15, so that only a small one can hide a zero area; an
    // edge that overflows gives a NaN, which is left to the exact test as well.
    const double rounded = aspect(x);
    if (rounded < smallest_aspect || (!(rounded > smallest_aspect) && has_zero_area(x)))
      add(findings, static_cast<std::size_t>(i), limit);
  }
  return findings;
}

Findings inverted_triangles(const Mesh& mesh, const std::vector<Index>& ids, std::size_t limit) {
  if (mesh.material.empty()) return {};
  std::vector<signed char> signs(ids.size(), 0);
  std::vector<bool> measured(ids.size(), false);
  std::int64_t balance = 0;
  for (std::size_t k = 0; k < ids.size(); ++k) {
    const auto m = material_corners(mesh, ids[k]);
    if (!has_finite_material(m)) continue;
    measured[k] = true;
    signs[k] = static_cast<signed char>(orientation(m));
    balance += signs[k];
  }
  const int usual = balance < 0 ? -1 : 1;
  Findings findings;
  for (std::size_t k = 0; k < ids.size(); ++k)
    if (measured[k] && signs[k] != usual) add(findings, static_cast<std::size_t>(ids[k]), limit);
  return findings;
}

StrainVerdict measure_strain(const Mesh& mesh, const std::vector<Index>& ids) {
  StrainVerdict verdict;
  if (mesh.material.empty()) return verdict;
  std::vector<double> largest, smallest;
  largest.reserve(ids.size());
  smallest.reserve(ids.size());
  for (const Index i : ids) {
    const Tri& t = mesh.triangles[static_cast<std::size_t>(i)];
    double s1 = 0, s2 = 0;
    if (!principal_stretches(corners(mesh.positions, t), material_corners(mesh, i), s1, s2))
      continue;
    largest.push_back(s1 - 1);
    smallest.push_back(s2 - 1);
  }
  verdict.triangle_count = static_cast<std::int64_t>(largest.size());
  verdict.largest = percentiles(largest);
  verdict.smallest = percentiles(smallest);
  return verdict;
}

}  // namespace weft::lab
