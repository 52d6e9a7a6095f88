#pragma once

// Where the target has no registers of that width the compiler says how it passes such arguments;
// all of these are inlined.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace weft {

/// Four numbers side by side, which templates on the scalar take for one: four elements at once,
/// each rounded as if it were alone.
struct Lanes {
  static constexpr int count = 4;
  typedef double Pack __attribute__((vector_size(count * sizeof(double))));

  Pack e;

  Lanes() = default;
  explicit Lanes(double x) : e{x, x, x, x} {}
  explicit Lanes(const Pack& pack) : e(pack) {}

  double operator[](int lane) const { return e[lane]; }
  void set(int lane, double x) { e[lane] = x; }

  Lanes& operator+=(const Lanes& b) {
    e += b.e;
    return *this;
  }
  Lanes& operator-=(const Lanes& b) {
    e -= b.e;
    return *this;
  }
  Lanes& operator*=(const Lanes& b) {
    e *= b.e;
    return *this;
  }
  friend Lanes operator+(Lanes a, const Lanes& b) { return a += b; }
  friend Lanes operator-(Lanes a, const Lanes& b) { return a -= b; }
  friend Lanes operator*(Lanes a, const Lanes& b) { return a *= b; }
  friend Lanes operator-(const Lanes& a) { return Lanes(-a.e); }
};

}  // namespace weft
