#include "host/geometry/similarity.hpp"

#include <cmath>
#include <cstddef>

namespace weft {
namespace {

Vec3<double> mean_of(const std::vector<Vec3<double>>& points) {
  Vec3<double> sum{};
  for (const Vec3<double>& x : points) sum += x;
  return points.empty() ? sum : sum * (1.0 / static_cast<double>(points.size()));
}

/// Eigenvector of the largest eigenvalue of a symmetric matrix, by Jacobi rotations.
void largest_eigenvector(double (&a)[4][4], double (&vector)[4]) {
  double v[4][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
  constexpr int sweeps = 30;  // quadratic convergence: some six are enough
  for (int sweep = 0; sweep < sweeps; ++sweep)
    for (int p = 0; p < 3; ++p)
      for (int q = p + 1; q < 4; ++q) {
        if (a[p][q] == 0) continue;
        const double theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
        const double t =
            (theta < 0 ? -1.0 : 1.0) / (std::abs(theta) + std::sqrt(theta * theta + 1));
        const double c = 1 / std::sqrt(t * t + 1);
        const double s = t * c;
        for (int k = 0; k < 4; ++k) {
          const double x = a[k][p], y = a[k][q];
          a[k][p] = c * x - s * y;
          a[k][q] = s * x + c * y;
        }
        for (int k = 0; k < 4; ++k) {
          const double x = a[p][k], y = a[q][k];
          a[p][k] = c * x - s * y;
          a[q][k] = s * x + c * y;
        }
        for (auto& row : v) {
          const double x = row[p], y = row[q];
          row[p] = c * x - s * y;
          row[q] = s * x + c * y;
        }
      }
  int best = 0;
  for (int k = 1; k < 4; ++k)
    if (a[k][k] > a[best][best]) best = k;
  for (int k = 0; k < 4; ++k) vector[k] = v[k][best];
}

}  // namespace

Vec3<double> Similarity::operator()(const Vec3<double>& x) const {
  const Vec3<double> u{rotation[0], rotation[1], rotation[2]};
  const Vec3<double> t = cross(u, x) * 2.0;
  return (x + t * rotation[3] + cross(u, t)) * scale + translate;
}

Similarity fitted_similarity(const std::vector<Vec3<double>>& from,
                             const std::vector<Vec3<double>>& to) {
  const Vec3<double> from_mean = mean_of(from);
  const Vec3<double> to_mean = mean_of(to);
  double s[3][3] = {};
  double from_square = 0;
  double to_square = 0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const Vec3<double> x = from[i] - from_mean;
    const Vec3<double> y = to[i] - to_mean;
    from_square += dot(x, x);
    to_square += dot(y, y);
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k) s[j][k] += x[j] * y[k];
  }
  // Horn's matrix for quaternions w, x, y, z.
  double n[4][4] = {
      {s[0][0] + s[1][1] + s[2][2], s[1][2] - s[2][1], s[2][0] - s[0][2], s[0][1] - s[1][0]},
      {s[1][2] - s[2][1], s[0][0] - s[1][1] - s[2][2], s[0][1] + s[1][0], s[2][0] + s[0][2]},
      {s[2][0] - s[0][2], s[0][1] + s[1][0], s[1][1] - s[0][0] - s[2][2], s[1][2] + s[2][1]},
      {s[0][1] - s[1][0], s[2][0] + s[0][2], s[1][2] + s[2][1], s[2][2] - s[0][0] - s[1][1]}};
  double q[4];
  largest_eigenvector(n, q);
  Similarity result;
  const double sign = q[0] < 0 ? -1 : 1;
  for (int k = 0; k < 4; ++k) result.rotation[k] = sign * q[(k + 1) % 4];
  if (from_square > 0 && to_square > 0) result.scale = std::sqrt(to_square / from_square);
  result.translate = {};
  result.translate = to_mean - result(from_mean);
  return result;
}

}  // namespace weft
