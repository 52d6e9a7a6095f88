#pragma once

#include <cstddef>
#include <utility>

#include "weft/state/tracked_rows.hpp"

namespace weft {

/// Keeps a solve by conjugate gradients to the vectors with C x = 0. With
///   Q = 1 - M^-1 C^T S^-1 C
/// directions are Q of what the preconditioner gives, residuals Q^T of what the matrix gives: that
/// is the method on the subspace, with Q P Q^T for a preconditioner (Gould, Hribar & Nocedal 2001).
/// Sums go row by row, in stored order, in double.
class Tracked {
 public:
  explicit Tracked(const TrackedRows& rows) : a_(rows) {}

  bool any() const { return a_.row_count > 0; }

  /// u = Q u
  template <class T>
  void project_direction(Span<Vec3<T>> u) const {
    for (std::size_t i = 0; i < rows(); ++i) sum(i) = -sum_of(i, u);
    add_multipliers(u, true);
  }

  /// r = Q^T r
  template <class T>
  void project_residual(Span<Vec3<T>> r) const {
    for (std::size_t i = 0; i < rows(); ++i) {
      Vec3<double> s{};
      for (auto e = begin(i); e < end(i); ++e)
        s += (a_.weight[e] * mass_inv(e)) * vec_cast<double>(r[vertex(e)]);
      sum(i) = -s;
    }
    add_multipliers(r, false);
  }

  /// The nearest x, by mass, with C x = wanted.
  template <class T>
  void meet(Span<Vec3<T>> x) const {
    for (std::size_t i = 0; i < rows(); ++i) sum(i) = a_.wanted[i] - sum_of(i, x);
    add_multipliers(x, true);
  }

 private:
  std::size_t rows() const { return static_cast<std::size_t>(a_.row_count); }
  std::size_t begin(std::size_t i) const { return static_cast<std::size_t>(a_.offset[i]); }
  std::size_t end(std::size_t i) const { return static_cast<std::size_t>(a_.offset[i + 1]); }
  std::size_t vertex(std::size_t e) const { return static_cast<std::size_t>(a_.vertex[e]); }
  double mass_inv(std::size_t e) const { return a_.mass_inv[vertex(e)]; }
  Vec3<double>& sum(std::size_t i) const { return a_.scratch[i]; }

  template <class T>
  Vec3<double> sum_of(std::size_t i, Span<Vec3<T>> x) const {
    Vec3<double> s{};
    for (auto e = begin(i); e < end(i); ++e) s += a_.weight[e] * vec_cast<double>(x[vertex(e)]);
    return s;
  }

  /// y += C^T S^-1 sum over free vertices, or M^-1 times that.
  template <class T>
  void add_multipliers(Span<Vec3<T>> y, bool by_mass) const {
    solve();
    for (std::size_t i = 0; i < rows(); ++i)
      for (auto e = begin(i); e < end(i); ++e) {
        const double scale = by_mass ? mass_inv(e) : mass_inv(e) > 0 ? 1.0 : 0.0;
        y[vertex(e)] += vec_cast<T>((scale * a_.weight[e]) * sum(i));
      }
  }

  /// sum = S^-1 sum
  void solve() const {
    const std::size_t n = rows();
    const Span<Vec3<double>> z = a_.scratch.subspan(n, n);
    for (std::size_t k = 0; k < n; ++k) z[k] = sum(static_cast<std::size_t>(a_.order[k]));
    const auto column = [this](std::size_t k) { return static_cast<std::size_t>(a_.column[k]); };
    const auto row = [this](std::size_t e) { return static_cast<std::size_t>(a_.factor_row[e]); };
    for (std::size_t k = 0; k < n; ++k)
      for (auto e = column(k); e < column(k + 1); ++e) z[row(e)] -= a_.factor[e] * z[k];
    for (std::size_t k = n; k-- > 0;) {
      z[k] = (1 / a_.pivot[k]) * z[k];
      for (auto e = column(k); e < column(k + 1); ++e) z[k] -= a_.factor[e] * z[row(e)];
    }
    for (std::size_t k = 0; k < n; ++k) sum(static_cast<std::size_t>(a_.order[k])) = z[k];
  }

  TrackedRows a_;
};

}  // namespace weft
