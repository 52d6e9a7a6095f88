#pragma once

// Where the target has no registers of that width the compiler says how it passes such arguments;
// all of these are inlined.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace weft {

/// Four numbers side by side, which templates on the scalar take for one: four elements at once,
/// each rounded as if it were alone.
struct Simd {
  static constexpr int count = 4;
  typedef double Pack __attribute__((vector_size(count * sizeof(double))));

  Pack e;

  Simd() = default;
  explicit Simd(double x) : e{x, x, x, x} {}
  explicit Simd(const Pack& pack) : e(pack) {}

  double operator[](int lane) const { return e[lane]; }
  void set(int lane, double x) { e[lane] = x; }

  Simd& operator+=(const Simd& b) {
    e += b.e;
    return *this;
  }
  Simd& operator-=(const Simd& b) {
    e -= b.e;
    return *this;
  }
  Simd& operator*=(const Simd& b) {
    e *= b.e;
    return *this;
  }
  friend Simd operator+(Simd a, const Simd& b) { return a += b; }
  friend Simd operator-(Simd a, const Simd& b) { return a -= b; }
  friend Simd operator*(Simd a, const Simd& b) { return a *= b; }
  friend Simd operator-(const Simd& a) { return Simd(-a.e); }
};

}  // namespace weft
