#include "benchmarks/physics/lateral_reference.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <numbers>
#include <vector>

namespace weft::physics {
namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

constexpr int along = 20;  // polynomials along the length
constexpr int across = 8;  // and across the width
constexpr int unknowns = along * across;
constexpr int points = 36;  // of Gauss's rule, each way

struct Rule {
  std::vector<double> x, w;
};

/// Gauss's rule on [-1, 1].
Rule gauss_rule() {
  Rule rule;
  for (int i = 0; i < points; ++i) {
    double x = std::cos(std::numbers::pi * (i + 0.75) / (points + 0.5));
    double slope = 1;
    for (int n = 0; n < 50; ++n) {
      double p = 1;
      double before = 0;
      for (int k = 1; k <= points; ++k) {
        const double next = ((2 * k - 1) * x * p - (k - 1) * before) / k;
        before = p;
        p = next;
      }
      slope = points * (x * p - before) / (x * x - 1);
      x -= p / slope;
    }
    rule.x.push_back(x);
    rule.w.push_back(2 / ((1 - x * x) * slope * slope));
  }
  return rule;
}

/// Value, first and second derivative.
struct Jet {
  double f, d, dd;
};

Jet product(const Jet& a, const Jet& b) {
  return {a.f * b.f, a.d * b.f + a.f * b.d, a.dd * b.f + 2 * a.d * b.d + a.f * b.dd};
}

/// Legendre polynomials at s, differentiated with respect to s times `rate`.
std::vector<Jet> legendre(double s, double rate, int count) {
  std::vector<Jet> p = {{1, 0, 0}, {s, rate, 0}};
  for (int k = 2; k < count; ++k) {
    const Jet sp = product({s, rate, 0}, p.back());
    const Jet& q = p[p.size() - 2];
    const double a = (2.0 * k - 1) / k;
    const double b = (k - 1.0) / k;
    p.push_back({a * sp.f - b * q.f, a * sp.d - b * q.d, a * sp.dd - b * q.dd});
  }
  return p;
}

/// Basis x^power P_i(2x - 1) P_j(2y/ratio) at a point: values and derivatives.
struct Basis {
  Vector f{unknowns}, x{unknowns}, y{unknowns}, xx{unknowns}, xy{unknowns}, yy{unknowns};
};

Basis basis_at(double x, double y, double ratio, int power) {
  const Jet clamp = power == 1 ? Jet{x, 1, 0} : Jet{x * x, 2 * x, 2};
  const auto px = legendre(2 * x - 1, 2, along);
  const auto py = legendre(2 * y / ratio, 2 / ratio, across);
  Basis b;
  for (int i = 0, n = 0; i < along; ++i) {
    const Jet a = product(clamp, px[static_cast<std::size_t>(i)]);
    for (int j = 0; j < across; ++j, ++n) {
      const Jet& c = py[static_cast<std::size_t>(j)];
      b.f[n] = a.f * c.f;
      b.x[n] = a.d * c.f;
      b.y[n] = a.f * c.d;
      b.xx[n] = a.dd * c.f;
      b.xy[n] = a.d * c.d;
      b.yy[n] = a.f * c.dd;
    }
  }
  return b;
}

/// In-plane displacement, u then v, of the plate of unit E h and weight.
Vector in_plane(const Rule& rule, double ratio, double nu) {
  const double c = 1 / (1 - nu * nu);
  const double shear = 1 / (2 * (1 + nu));
  Matrix k = Matrix::Zero(2 * unknowns, 2 * unknowns);
  Vector load = Vector::Zero(2 * unknowns);
  for (int a = 0; a < points; ++a)
    for (int b = 0; b < points; ++b) {
      const auto i = static_cast<std::size_t>(a);
      const auto j = static_cast<std::size_t>(b);
      const Basis s = basis_at((rule.x[i] + 1) / 2, rule.x[j] * ratio / 2, ratio, 1);
      const double w = rule.w[i] * rule.w[j] * ratio / 4;
      k.topLeftCorner(unknowns, unknowns) +=
          w * (c * s.x * s.x.transpose() + shear * s.y * s.y.transpose());
      k.bottomRightCorner(unknowns, unknowns) +=
          w * (c * s.y * s.y.transpose() + shear * s.x * s.x.transpose());
      k.topRightCorner(unknowns, unknowns) +=
          w * (c * nu * s.x * s.y.transpose() + shear * s.y * s.x.transpose());
      load.tail(unknowns) -= w * s.f;
    }
  k.bottomLeftCorner(unknowns, unknowns) = k.topRightCorner(unknowns, unknowns).transpose();
  return k.ldlt().solve(load);
}

}  // namespace

double lateral_buckling_load(double ratio, double nu) {
  const Rule rule = gauss_rule();
  const Vector plane = in_plane(rule, ratio, nu);
  Matrix bending = Matrix::Zero(unknowns, unknowns);
  Matrix stress = Matrix::Zero(unknowns, unknowns);
  for (int a = 0; a < points; ++a)
    for (int b = 0; b < points; ++b) {
      const auto i = static_cast<std::size_t>(a);
      const auto j = static_cast<std::size_t>(b);
      const double x = (rule.x[i] + 1) / 2;
      const double y = rule.x[j] * ratio / 2;
      const double w = rule.w[i] * rule.w[j] * ratio / 4;
      const Basis s = basis_at(x, y, ratio, 1);
      const double ex = s.x.dot(plane.head(unknowns));
      const double ey = s.y.dot(plane.tail(unknowns));
      const double exy = s.y.dot(plane.head(unknowns)) + s.x.dot(plane.tail(unknowns));
      const double nx = (ex + nu * ey) / (1 - nu * nu);
      const double ny = (ey + nu * ex) / (1 - nu * nu);
      const double nxy = exy / (2 * (1 + nu));
      const Basis t = basis_at(x, y, ratio, 2);
      bending += w * (t.xx * t.xx.transpose() + t.yy * t.yy.transpose() +
                      nu * (t.xx * t.yy.transpose() + t.yy * t.xx.transpose()) +
                      2 * (1 - nu) * t.xy * t.xy.transpose());
      stress += w * (nx * t.x * t.x.transpose() + ny * t.y * t.y.transpose() +
                     nxy * (t.x * t.y.transpose() + t.y * t.x.transpose()));
    }
  const Eigen::GeneralizedSelfAdjointEigenSolver<Matrix> eigen(-stress, bending,
                                                               Eigen::EigenvaluesOnly);
  return 1 / eigen.eigenvalues().maxCoeff();
}

double slender_lateral_load(double nu) {
  return 12.85 * std::numbers::sqrt2 * (1 - nu * nu) / std::sqrt(1 + nu);
}

}  // namespace weft::physics
