#include "host/geometry/plane_side.hpp"

#include <array>
#include <cmath>
#include <cstddef>

#include "weft/elements/scalar.hpp"

namespace weft {
namespace {

using Point = Vec3<double>;

/// A number as an exact sum of doubles that do not overlap, in increasing magnitude.
class ExactSum {
 public:
  void add(double x) {
    if (x == 0) return;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < size_; ++i) {
      const double sum = x + terms_[i];
      const double part = sum - x;
      const double lost = (x - (sum - part)) + (terms_[i] - part);
      if (lost != 0) terms_[kept++] = lost;
      x = sum;
    }
    if (x != 0) terms_[kept++] = x;
    size_ = kept;
  }
  /// The largest term outweighs all others together.
  int sign() const { return size_ == 0 ? 0 : (terms_[size_ - 1] > 0 ? 1 : -1); }

 private:
  std::array<double, 192> terms_;  // a determinant: 6 products of 2 x 2 x 2 parts, 4 terms each
  std::size_t size_ = 0;
};

/// a - b as an exact sum of two doubles.
std::array<double, 2> exact_difference(double a, double b) {
  const double difference = a - b;
  const double part = a - difference;
  return {difference, (a - (difference + part)) + (part - b)};
}

/// Adds x y z, exactly but for underflow.
void add_product(ExactSum& sum, double x, double y, double z) {
  const double xy = x * y;
  const double xy_lost = std::fma(x, y, -xy);
  for (const double factor : {xy, xy_lost}) {
    const double product = factor * z;
    sum.add(product);
    sum.add(std::fma(factor, z, -product));
  }
}

int exact_side(const Point& a, const Point& b, const Point& c, const Point& d) {
  const std::array<const Point*, 3> rows{&a, &b, &c};
  std::array<std::array<std::array<double, 2>, 3>, 3> m;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      m[i][j] = exact_difference((*rows[i])[static_cast<int>(j)], d[static_cast<int>(j)]);
  ExactSum det;
  for (std::size_t j = 0; j < 3; ++j)
    for (const double x : m[0][j])
      for (const double y : m[1][(j + 1) % 3])
        for (const double z : m[2][(j + 2) % 3]) add_product(det, x, y, z);
  for (std::size_t j = 0; j < 3; ++j)
    for (const double x : m[0][j])
      for (const double y : m[1][(j + 2) % 3])
        for (const double z : m[2][(j + 1) % 3]) add_product(det, -x, y, z);
  return det.sign();
}

}  // namespace

int plane_side(const Point& a, const Point& b, const Point& c, const Point& d) {
  const Point p = a - d;
  const Point q = b - d;
  const Point r = c - d;
  double det = 0;
  double size = 0;
  for (int j = 0; j < 3; ++j) {
    const double forward = q[(j + 1) % 3] * r[(j + 2) % 3];
    const double backward = q[(j + 2) % 3] * r[(j + 1) % 3];
    det += p[j] * (forward - backward);
    size += std::fabs(p[j]) * (std::fabs(forward) + std::fabs(backward));
  }
  // A term passes through fewer than ten roundings of half an epsilon each.
  if (std::fabs(det) > 8 * epsilon<double> * size + smallest_normal<double>)
    return det > 0 ? 1 : -1;
  return exact_side(a, b, c, d);
}

}  // namespace weft
