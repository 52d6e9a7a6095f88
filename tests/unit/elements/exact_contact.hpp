#pragma once

#include <gmpxx.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "weft/core/vec.hpp"

// Whether and when two moving primitives touch, decided in rational arithmetic without rounding.
//
// Contact at a time is a matter of signs of polynomials in t. The set of contact times is closed,
// and at its least element either t = 0 or one of these polynomials has a root. So the signs are
// asked at the roots, which are kept as isolating intervals of Sturm sequences.

namespace weft::test {

/// Coefficients in ascending order, without leading zeros; empty: zero.
using Poly = std::vector<mpq_class>;

inline void trim(Poly& p) {
  while (!p.empty() && sgn(p.back()) == 0) p.pop_back();
}

inline Poly operator+(const Poly& a, const Poly& b) {
  Poly c = a;
  if (c.size() < b.size()) c.resize(b.size());
  for (std::size_t i = 0; i < b.size(); ++i) c[i] += b[i];
  trim(c);
  return c;
}

inline Poly operator-(const Poly& a) {
  Poly c = a;
  for (auto& x : c) x = -x;
  return c;
}

inline Poly operator-(const Poly& a, const Poly& b) {
  return a + -b;
}

inline Poly operator*(const Poly& a, const Poly& b) {
  if (a.empty() || b.empty()) return {};
  Poly c(a.size() + b.size() - 1);
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t j = 0; j < b.size(); ++j) c[i + j] += a[i] * b[j];
  return c;
}

inline Poly derivative(const Poly& p) {
  Poly d;
  for (std::size_t i = 1; i < p.size(); ++i) d.push_back(p[i] * static_cast<unsigned long>(i));
  return d;
}

inline int sign_at(const Poly& p, const mpq_class& t) {
  mpq_class v = 0;
  for (std::size_t i = p.size(); i-- > 0;) v = v * t + p[i];
  return sgn(v);
}

/// Quotient and remainder; the divisor is not zero.
inline std::pair<Poly, Poly> divide(Poly a, const Poly& b) {
  if (a.size() < b.size()) return {{}, std::move(a)};
  Poly quotient(a.size() - b.size() + 1);
  for (std::size_t k = quotient.size(); k-- > 0;) {
    const mpq_class f = a[k + b.size() - 1] / b.back();
    quotient[k] = f;
    for (std::size_t i = 0; i < b.size(); ++i) a[k + i] -= f * b[i];
  }
  trim(a);
  return {quotient, a};
}

/// Scaled by a positive number so that numbers stay short.
inline Poly shortened(Poly p) {
  if (p.empty()) return p;
  const mpq_class scale = abs(p.back());
  for (auto& x : p) x /= scale;
  return p;
}

inline Poly common_divisor(Poly a, Poly b) {
  while (!b.empty()) {
    Poly rest = shortened(divide(a, b).second);
    a = std::move(b);
    b = std::move(rest);
  }
  return shortened(a);
}

/// With the same roots, each of them simple; not for zero.
inline Poly square_free(const Poly& p) {
  return shortened(divide(p, common_divisor(p, derivative(p))).first);
}

/// Sturm's sequence of a polynomial with simple roots.
class Sturm {
 public:
  Sturm() = default;
  explicit Sturm(const Poly& p) {
    chain_.push_back(p);
    chain_.push_back(derivative(p));
    while (!chain_.back().empty())
      chain_.push_back(shortened(-divide(chain_[chain_.size() - 2], chain_.back()).second));
    chain_.pop_back();
  }
  const Poly& poly() const { return chain_.front(); }
  /// Number of roots in (a, b].
  int roots(const mpq_class& a, const mpq_class& b) const { return changes(a) - changes(b); }

 private:
  int changes(const mpq_class& t) const {
    int count = 0, last = 0;
    for (const Poly& p : chain_) {
      const int s = sign_at(p, t);
      if (s == 0) continue;
      count += last != 0 && s != last;
      last = s;
    }
    return count;
  }
  std::vector<Poly> chain_;
};

/// A root of a polynomial: the only one in (lo, hi], or the rational number lo = hi.
struct Root {
  Sturm f;
  mpq_class lo, hi;

  bool rational() const { return lo == hi; }
  void halve() {
    const mpq_class mid = (lo + hi) / 2;
    (f.roots(lo, mid) == 1 ? hi : lo) = mid;
  }
};

/// Sign of g at a root; narrows its interval.
inline int sign_at(const Poly& g, Root& root) {
  if (g.empty()) return 0;
  if (root.rational()) return sign_at(g, root.lo);
  const Poly both = common_divisor(root.f.poly(), g);
  if (both.size() > 1 && Sturm(square_free(both)).roots(root.lo, root.hi) > 0) return 0;
  const Sturm own(square_free(g));
  while (own.roots(root.lo, root.hi) > 0 || sign_at(g, root.lo) == 0) root.halve();
  return sign_at(g, root.hi);
}

/// Roots in [0, 1], not for zero.
inline std::vector<Root> roots_of(const Poly& p) {
  std::vector<Root> found;
  if (sign_at(p, 0) == 0) found.push_back({Sturm(), 0, 0});
  if (p.size() < 2) return found;
  const Sturm f(square_free(p));
  const std::function<void(const mpq_class&, const mpq_class&)> isolate = [&](const mpq_class& lo,
                                                                              const mpq_class& hi) {
    const int count = f.roots(lo, hi);
    if (count == 0) return;
    if (count == 1) {
      found.push_back({f, lo, hi});
      return;
    }
    const mpq_class mid = (lo + hi) / 2;
    isolate(lo, mid);
    isolate(mid, hi);
  };
  isolate(0, 1);
  return found;
}

using PolyVec = std::array<Poly, 3>;

inline PolyVec operator-(const PolyVec& a, const PolyVec& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

inline Poly dot(const PolyVec& a, const PolyVec& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

inline PolyVec cross(const PolyVec& a, const PolyVec& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// The polynomials whose signs say whether there is contact.
struct ContactSigns {
  Poly coplanar;             ///< zero: coplanar
  PolyVec normal;            ///< zero: degenerate
  std::vector<Poly> within;  ///< none negative: contact, if coplanar and not degenerate
  struct OnSegment {
    PolyVec off;  ///< zero: the point is on the segment's line
    Poly beyond;  ///< not positive: then it is on the segment
  };
  std::vector<OnSegment> on_segment;  ///< any: contact, if degenerate
};

inline ContactSigns::OnSegment on_segment(const PolyVec& p, const PolyVec& a, const PolyVec& b) {
  return {cross(b - a, p - a), dot(p - a, p - b)};
}

template <class T>
ContactSigns contact_signs(bool edges, const Vec3<T> (&x_t0)[4], const Vec3<T> (&x_t1)[4]) {
  // By a power of two, so that numbers stay short.
  double largest = 0;
  for (int j = 0; j < 4; ++j)
    for (int c = 0; c < 3; ++c)
      largest = std::max({largest, std::fabs(double(x_t0[j][c])), std::fabs(double(x_t1[j][c]))});
  const int exponent = largest > 0 ? std::ilogb(largest) : 0;
  const auto scaled = [&](T value) {
    mpq_class r(static_cast<double>(value));
    if (exponent > 0)
      mpq_div_2exp(r.get_mpq_t(), r.get_mpq_t(), static_cast<mp_bitcnt_t>(exponent));
    else
      mpq_mul_2exp(r.get_mpq_t(), r.get_mpq_t(), static_cast<mp_bitcnt_t>(-exponent));
    return r;
  };
  PolyVec x[4];
  for (std::size_t j = 0; j < 4; ++j)
    for (std::size_t c = 0; c < 3; ++c) {
      const mpq_class start = scaled(x_t0[j][static_cast<int>(c)]);
      const mpq_class end = scaled(x_t1[j][static_cast<int>(c)]);
      x[j][c] = {start, end - start};
      trim(x[j][c]);
    }
  ContactSigns s;
  if (edges) {
    const PolyVec d1 = x[1] - x[0], d2 = x[3] - x[2], r = x[2] - x[0];
    s.normal = cross(d1, d2);
    s.coplanar = dot(s.normal, r);
    const Poly all = dot(s.normal, s.normal);
    for (const PolyVec& d : {d2, d1}) {
      const Poly along = dot(cross(r, d), s.normal);
      s.within.push_back(along);
      s.within.push_back(all - along);
    }
    for (std::size_t i = 0; i < 2; ++i) {
      s.on_segment.push_back(on_segment(x[i], x[2], x[3]));
      s.on_segment.push_back(on_segment(x[2 + i], x[0], x[1]));
    }
  } else {
    s.normal = cross(x[2] - x[1], x[3] - x[1]);
    s.coplanar = dot(s.normal, x[0] - x[1]);
    for (std::size_t j = 0; j < 3; ++j) {
      const PolyVec &a = x[1 + j], &b = x[1 + (j + 1) % 3];
      s.within.push_back(dot(s.normal, cross(b - a, x[0] - a)));
      s.on_segment.push_back(on_segment(x[0], a, b));
    }
  }
  return s;
}

/// Whether there is contact at a root.
inline bool touch(const ContactSigns& s, Root& at) {
  if (sign_at(s.coplanar, at) != 0) return false;
  const auto vanishes = [&](const PolyVec& v) {
    return sign_at(v[0], at) == 0 && sign_at(v[1], at) == 0 && sign_at(v[2], at) == 0;
  };
  if (!vanishes(s.normal)) {
    for (const Poly& p : s.within)
      if (sign_at(p, at) < 0) return false;
    return true;
  }
  for (const auto& segment : s.on_segment)
    if (vanishes(segment.off) && sign_at(segment.beyond, at) <= 0) return true;
  return false;
}

/// An upper bound, within 2^-80, of the first time at which they touch; empty: never.
template <class T>
std::optional<mpq_class> first_contact(bool edges, const Vec3<T> (&x_t0)[4],
                                       const Vec3<T> (&x_t1)[4]) {
  const ContactSigns s = contact_signs(edges, x_t0, x_t1);
  std::vector<Poly> polys;
  if (!s.coplanar.empty()) {
    polys = {s.coplanar};
  } else {  // coplanar all the time
    polys.assign(s.normal.begin(), s.normal.end());
    polys.insert(polys.end(), s.within.begin(), s.within.end());
    for (const auto& segment : s.on_segment) {
      polys.insert(polys.end(), segment.off.begin(), segment.off.end());
      polys.push_back(segment.beyond);
    }
  }
  std::vector<Root> times = {{Sturm(), 0, 0}};
  for (const Poly& p : polys) {
    if (p.empty()) continue;
    for (Root& root : roots_of(p)) times.push_back(std::move(root));
  }
  const mpq_class width(mpz_class(1), mpz_class(1) << 80);
  std::optional<mpq_class> first;
  for (Root& root : times) {
    if (!touch(s, root)) continue;
    while (root.hi - root.lo > width) root.halve();
    if (!first || root.hi < *first) first = root.hi;
  }
  return first;
}

}  // namespace weft::test
