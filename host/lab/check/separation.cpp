#include "host/lab/check/separation.hpp"

#include <algorithm>
#include <cmath>

namespace weft::lab {
namespace {

// n.(x - o) in floating point, with x - o rounded: three subtractions, three products and two sums,
// each off by at most u = 2^-53 of its result. The total is below 5 u sum |n_i (x - o)_i|; the
// factor is doubled, which also covers the rounding of that sum itself. Underflow of a product is
// below 2^-1074 and covered by `underflow`.
constexpr double relative_error = 10 * 0x1p-53;
constexpr double underflow = 1e-300;

// Outside this range products of three lengths could overflow or lose all their bits.
constexpr double smallest_length = 1e-60;
constexpr double largest_length = 1e60;

struct Range {
  double lo;  // no more than the exact value at any of the points
  double hi;  // no less
};

/// Bounds of n.(x - o) over three points, given the rounded differences x - o.
Range bounds(const Vec3<double>& n, const Corners& from_origin) noexcept {
  Range r{};
  for (int i = 0; i < 3; ++i) {
    const Vec3<double>& x = from_origin[static_cast<std::size_t>(i)];
    const double p0 = n[0] * x[0], p1 = n[1] * x[1], p2 = n[2] * x[2];
    const double value = p0 + p1 + p2;
    const double error =
        relative_error * (std::fabs(p0) + std::fabs(p1) + std::fabs(p2)) + underflow;
    const double lo = value - error, hi = value + error;
    r.lo = i == 0 ? lo : std::min(r.lo, lo);
    r.hi = i == 0 ? hi : std::max(r.hi, hi);
  }
  return r;
}

bool separates(const Vec3<double>& n, const Corners& s, const Corners& t) noexcept {
  const Range a = bounds(n, s), b = bounds(n, t);
  return a.hi < b.lo || b.hi < a.lo;
}

double magnitude(const Vec3<double>& x) noexcept {
  return std::max({std::fabs(x[0]), std::fabs(x[1]), std::fabs(x[2])});
}

bool usable(double length) noexcept {
  return length > smallest_length && length < largest_length;
}

/// x scaled to length one; zero where x has no usable length.
Vec3<double> unit(const Vec3<double>& x) noexcept {
  const double m = magnitude(x);
  if (!usable(m)) return {};
  const Vec3<double> y = x * (1 / m);
  return y * (1 / length(y));
}

/// Sum of unit vectors along a and b, divided by its squared length.
Vec3<double> weighted_bisector(const Vec3<double>& a, const Vec3<double>& b) noexcept {
  const Vec3<double> sum = unit(a) + unit(b);
  const double sq = length_sq(sum);
  if (!(sq > 1e-12)) return {};
  return sum * (1 / sq);
}

}  // namespace

bool certainly_apart(const Corners& s_world, const Corners& t_world) noexcept {
  const Vec3<double> origin = s_world[0];
  Corners s{}, t{};
  double extent = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    s[i] = s_world[i] - origin;
    t[i] = t_world[i] - origin;
    extent = std::max({extent, magnitude(s[i]), magnitude(t[i])});
  }
  if (!usable(extent)) return false;

  const std::array<Vec3<double>, 3> es{s[1] - s[0], s[2] - s[1], s[0] - s[2]};
  const std::array<Vec3<double>, 3> et{t[1] - t[0], t[2] - t[1], t[0] - t[2]};
  const Vec3<double> ns = cross(es[0], es[1]);
  const Vec3<double> nt = cross(et[0], et[1]);
  // Any direction is a sound candidate, however roughly it was computed: these are the separating
  // axes of two triangles, in space and in a common plane, cheapest and most likely first.
  if (separates(ns, s, t) || separates(nt, s, t)) return true;
  if (separates((t[0] + t[1] + t[2]) - (s[0] + s[1] + s[2]), s, t)) return true;
  for (const auto& a : es)
    if (separates(cross(ns, a), s, t)) return true;
  for (const auto& b : et)
    if (separates(cross(nt, b), s, t)) return true;
  for (const auto& a : es)
    for (const auto& b : et)
      if (separates(cross(a, b), s, t)) return true;
  return false;
}

bool certainly_apart_beyond(const Vec3<double>& v, const Vec3<double>& a, const Vec3<double>& b,
                            const Vec3<double>& c, const Vec3<double>& d) noexcept {
  const Corners s{a - v, b - v, a - v};
  const Corners t{c - v, d - v, c - v};
  for (const auto& x : {s[0], s[1], t[0], t[1]})
    if (!usable(magnitude(x))) return false;
  // v is at zero. If n is positive on a and b and negative on c and d, the plane through v keeps
  // the triangles apart everywhere else. Of two sectors in one plane, the weights turn n so that
  // it separates them whenever there is a gap, however different their angles.
  const Vec3<double> n = weighted_bisector(s[0], s[1]) - weighted_bisector(t[0], t[1]);
  const Range on_s = bounds(n, s), on_t = bounds(n, t);
  return on_s.lo > 0 && on_t.hi < 0;
}

}  // namespace weft::lab
