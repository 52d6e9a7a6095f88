#include "host/geometry/tensor.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace weft {
namespace {

struct Disk {
  Vec2<double> centre;
  double radius;
};

Disk disk_of(const Mat2<double>& m) {
  return {{(m(0, 0) - m(1, 1)) / 2, (m(0, 1) + m(1, 0)) / 2}, (m(0, 0) + m(1, 1)) / 2};
}

Mat2<double> tensor_of(const Disk& d) {
  return {{d.radius + d.centre[0], d.centre[1], d.centre[1], d.radius - d.centre[0]}};
}

using Disks = ShortList<Disk, tensors_max>;
/// One each, one of two, two of three.
using Centres = ShortList<Vec2<double>, tensors_max + tensors_max*(tensors_max - 1) / 2 +
                                            tensors_max*(tensors_max - 1) * (tensors_max - 2) / 3>;

/// How far a disk at `centre` must reach to hold them all; or more than `enough`, if it must.
double reach(const Disks& disks, const Vec2<double>& centre, double enough) {
  double radius = -std::numeric_limits<double>::infinity();
  for (const Disk& d : disks) {
    radius = std::max(radius, length(d.centre - centre) + d.radius);
    if (radius > enough) break;
  }
  return radius;
}

bool holds(const Disk& outer, const Disk& inner) {
  return length(inner.centre - outer.centre) + inner.radius <= outer.radius;
}

/// The disk that just holds two of which neither holds the other.
Disk around(const Disk& a, const Disk& b) {
  const Vec2<double> way = b.centre - a.centre;
  const double apart = length(way);
  if (apart + b.radius <= a.radius) return a;
  if (apart + a.radius <= b.radius) return b;
  const double radius = (apart + a.radius + b.radius) / 2;
  return {a.centre + ((radius - a.radius) / apart) * way, radius};
}

/// Centres of disks that three touch from within: |c - c_i| = R - r_i.
void touch_three(const Disk& a, const Disk& b, const Disk& c, Centres& centres) {
  // Differences of the squared equations are linear in c and R: with p = c - c_a,
  //   2 p . d_i + 2 R (r_a - r_i) = |d_i|^2 + r_a^2 - r_i^2
  const Vec2<double> d = b.centre - a.centre;
  const Vec2<double> e = c.centre - a.centre;
  const double det = 4 * (d[0] * e[1] - d[1] * e[0]);
  if (std::abs(det) <= 1e-14 * (length_sq(d) + length_sq(e))) return;
  const double m0 = length_sq(d) + a.radius * a.radius - b.radius * b.radius;
  const double m1 = length_sq(e) + a.radius * a.radius - c.radius * c.radius;
  const double n0 = -2 * (a.radius - b.radius);
  const double n1 = -2 * (a.radius - c.radius);
  const auto solve = [&](double s, double t) {
    return Vec2<double>{(2 * e[1] * s - 2 * d[1] * t) / det, (2 * d[0] * t - 2 * e[0] * s) / det};
  };
  const Vec2<double> p = solve(m0, m1);  // at R = 0
  const Vec2<double> q = solve(n0, n1);  // and its slope over R
  // |p + q R|^2 = (R - r_a)^2
  const double qa = length_sq(q) - 1;
  const double qb = dot(p, q) + a.radius;
  const double qc = length_sq(p) - a.radius * a.radius;
  const double under = qb * qb - qa * qc;
  if (!(under >= 0)) return;
  const double root = std::sqrt(under);
  if (std::abs(qa) > 1e-14) {
    centres.push_back(a.centre + p + ((-qb + root) / qa) * q);
    centres.push_back(a.centre + p + ((-qb - root) / qa) * q);
  } else if (qb != 0) {
    centres.push_back(a.centre + p + (-qc / (2 * qb)) * q);
  }
}

template <class Change>
Mat2<double> with_values(const Mat2<double>& m, Change change) {
  Eigen2 e = eigen(m);
  for (double& value : e.value) value = change(value);
  return compose(e);
}

}  // namespace

Eigen2 eigen(const Mat2<double>& m) {
  const double mean = (m(0, 0) + m(1, 1)) / 2;
  const double half = (m(0, 0) - m(1, 1)) / 2;
  const double off = (m(0, 1) + m(1, 0)) / 2;
  const double radius = std::hypot(half, off);
  const double angle = std::atan2(off, half) / 2;
  return {{mean + radius, mean - radius}, {std::cos(angle), std::sin(angle)}};
}

Mat2<double> compose(const Eigen2& e) {
  const Vec2<double> other{-e.axis[1], e.axis[0]};
  return e.value[0] * outer(e.axis, e.axis) + e.value[1] * outer(other, other);
}

Mat2<double> tensor_above(const Tensors& tensors) {
  // What another holds asks for nothing: many a tensor is zero.
  Disks disks;
  for (const Mat2<double>& m : tensors) {
    const Disk d = disk_of(m);
    if (std::any_of(disks.begin(), disks.end(), [&d](const Disk& o) { return holds(o, d); }))
      continue;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < disks.size(); ++i)
      if (!holds(d, disks[i])) disks[kept++] = disks[i];
    disks.shorten(kept);
    disks.push_back(d);
  }
  // The smallest disk touches at most three of them; there are few, so all are tried.
  Centres centres;
  for (std::size_t i = 0; i < disks.size(); ++i) {
    centres.push_back(disks[i].centre);
    for (std::size_t j = 0; j < i; ++j) {
      centres.push_back(around(disks[i], disks[j]).centre);
      for (std::size_t k = 0; k < j; ++k) touch_three(disks[i], disks[j], disks[k], centres);
    }
  }
  Disk best{{0, 0}, std::numeric_limits<double>::infinity()};
  for (const Vec2<double>& centre : centres) {
    const double radius = reach(disks, centre, best.radius);
    if (radius < best.radius) best = {centre, radius};
  }
  return tensor_of(best);
}

Mat2<double> clamped(const Mat2<double>& m, double low, double high, double aspect_sq) {
  Eigen2 e = eigen(m);
  for (double& value : e.value) value = std::clamp(value, low, high);
  e.value[1] = std::max(e.value[1], aspect_sq * e.value[0]);
  return compose(e);
}

Mat2<double> compression_tensor(const Mat2<double>& green, const Mat2<double>& curvature_sq,
                                double compression) {
  const double c = compression;
  const Mat2<double>& k = curvature_sq;
  const Mat2<double> perp{{k(1, 1), -k(0, 1), -k(1, 0), k(0, 0)}};
  const Mat2<double> under = transpose(green) * green - (4 * c * c) * perp;
  const Mat2<double> root =
      with_values(under, [](double x) { return std::copysign(std::sqrt(std::abs(x)), x); });
  const Mat2<double> sum = root - green;
  return (1 / (2 * c * c)) * with_values(sum, [](double x) { return std::max(x, 0.0); });
}

}  // namespace weft
