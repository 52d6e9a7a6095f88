#pragma once

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <vector>

#include "host/solve/aggregate.hpp"
#include "host/solve/contact_product.hpp"
#include "host/solve/slice_sums.hpp"
#include "host/solve/whole_blocks.hpp"
#include "weft/kernels/solve/pcg.hpp"

namespace weft::pcg {

constexpr Index lanes = host_slice;

/// Rows [first, last) of a rank; `first` begins a slice of the mesh.
struct RowRange {
  Index first, last;
};

/// y = vertex part and rows of the mesh's matrices times u.
/// @param begin vertex of row 0
template <class T>
void multiply_mesh(const SolvePcgPart<T>& part, const RowRange& range, Index begin,
                   Span<const Vec3<T>> u, Span<Vec3<T>> y) {
  const BlockEll<T>& mesh = part.mesh;
  const ScalarEll<T>& far = part.far;
  for (Index first = range.first; first < range.last; first += lanes) {
    Index own[lanes];
    T mass[lanes];
    for (Index lane = 0; lane < lanes; ++lane) {
      // Lanes beyond the last row repeat it.
      const Index row = std::min(first + lane, mesh.row_count - 1);
      own[lane] = begin + row;
      mass[lane] = part.vertex.mass.data()[row];
    }
    SliceSums<T> sums(u.data()->e, own, mass);
    const Index count = std::min(lanes, range.last - first);
    if (!part.vertex.drag.empty()) {
      T drag[3][lanes] = {};
      for (Index lane = 0; lane < count; ++lane) {
        const Vec3<T> term = part.vertex.drag.load(first + lane) * u.data()[own[lane]];
        for (int c = 0; c < 3; ++c) drag[c][lane] = term[c];
      }
      sums.add(drag[0]);
    }
    const auto slice = static_cast<std::size_t>(first / lanes);
    for (Offset slot = mesh.slice_offset[slice]; slot < mesh.slice_offset[slice + 1]; ++slot)
      sums.add_blocks(mesh.value.data() + slot * 9 * lanes, mesh.column.data() + slot * lanes);
    if (far.row_count > 0)
      for (Offset slot = far.slice_offset[slice]; slot < far.slice_offset[slice + 1]; ++slot)
        sums.add_scalars(far.value.data() + slot * lanes, far.column.data() + slot * lanes);
    sums.store(y.data() + first, count);
  }
}

/// y += |A| |u|, of a matrix of blocks or of multiples of the identity.
template <class T, class Matrix>
void add_magnitudes(const Matrix& m, Span<const Vec3<T>> u, Span<Vec3<T>> y) {
  constexpr bool blocks = std::is_same_v<Matrix, BlockEll<T>>;
  for (Index row = 0; row < m.row_count; ++row) {
    const auto slice = static_cast<std::size_t>(row / m.slice);
    const Index lane = row % m.slice;
    for (Offset slot = m.slice_offset[slice]; slot < m.slice_offset[slice + 1]; ++slot) {
      const Vec3<T>& x = u.data()[m.column.data()[slot * m.slice + lane]];
      const T* value = m.value.data() + slot * (blocks ? 9 : 1) * m.slice + lane;
      for (int k = 0; k < (blocks ? 9 : 3); ++k)
        y.data()[row][blocks ? k / 3 : k] +=
            std::abs(value[blocks ? k * m.slice : 0] * x[blocks ? k % 3 : k]);
    }
  }
}

/// Dot product of `count` numbers in double, over fixed lanes so that it can use vector registers.
template <class T>
double dot_block(const T* a, const T* b, std::size_t count) {
  double sum[lanes] = {};
  std::size_t i = 0;
  for (; i + lanes <= count; i += lanes)
    for (std::size_t lane = 0; lane < lanes; ++lane)
      sum[lane] += static_cast<double>(a[i + lane]) * static_cast<double>(b[i + lane]);
  for (std::size_t lane = 0; i + lane < count; ++lane)
    sum[lane] += static_cast<double>(a[i + lane]) * static_cast<double>(b[i + lane]);
  return ((sum[0] + sum[4]) + (sum[1] + sum[5])) + ((sum[2] + sum[6]) + (sum[3] + sum[7]));
}

/// What one rank of a solve computes of its own rows: the same with every transport.
template <class T>
class Rows {
 public:
  /// Both are referred to.
  Rows(const SolvePcg<T>& args, const SolvePcgPart<T>& part)
      : me_(part),
        begin_(args.row_begin[static_cast<std::size_t>(args.rank)]),
        rows_(static_cast<std::size_t>(args.row_begin[static_cast<std::size_t>(args.rank) + 1] -
                                       begin_)),
        step_(static_cast<std::size_t>(std::min(args.partial_rows, pcg_partial_rows_max))),
        partials_(static_cast<std::size_t>(
            pcg_partials(args.row_begin[args.row_begin.size() - 1], args.partial_rows))) {}

  Index begin() const { return begin_; }
  Index count() const { return static_cast<Index>(rows_); }
  std::size_t partial_rows() const { return step_; }
  /// Partial sums of all ranks.
  std::size_t partials() const { return partials_; }

  /// w = A v in free rows, zero in fixed ones.
  void multiply(Span<const Vec3<T>> v) const {
    if (!me_.contact.count.empty()) gather_contacts(me_.contact, v.data()->e);
    multiply_range<true>({0, count()}, v);
  }
  /// w = A u as above, and sum_products() to `out`, block by block.
  void multiply_and_sum(double* out) const {
    if (step_ % lanes != 0) {  // blocks are no whole slices
      multiply(me_.u);
      return sum_products(out);
    }
    if (!me_.contact.count.empty()) gather_contacts(me_.contact, me_.u.data()->e);
    for_each_block([&](std::size_t first, std::size_t last) {
      multiply_range<true>({static_cast<Index>(first), static_cast<Index>(last)}, me_.u);
      sum_products(first, last, out);
    });
  }
  /// The same in a range of rows, to the same bits.
  void multiply(const RowRange& range, Span<const Vec3<T>> v) const {
    multiply_range<false>(range, v);
  }

  /// r = b - w in free rows, u = P r but for aggregates.
  void take_residual() const {
    for (std::size_t i = 0; i < rows_; ++i) me_.r[i] = fixed(i) ? Vec3<T>{} : me_.rhs[i] - me_.w[i];
    precondition();
  }

  /// u = P r but for aggregates.
  void precondition() const { precondition(0, rows_); }

  /// One step along the direction that u gives, then u = P r: all of it a block of rows at a time,
  /// while its vectors are in the cache.
  void update(T alpha, T beta) const {
    for_each_block([&](std::size_t first, std::size_t last) {
      if (beta == T(0))
        step<true>(alpha, beta, first, last);
      else
        step<false>(alpha, beta, first, last);
      precondition(first, last);
      correct(first, last);
    });
  }

  /// Adds to u what the aggregates that move as one make of r.
  void correct() const {
    for_each_block([&](std::size_t first, std::size_t last) { correct(first, last); });
  }

  /// Own partial sums of (r, u), (w, u), (r, r), to [3 * partials()].
  void sum_products(double* out) const {
    for_each_block([&](std::size_t first, std::size_t last) { sum_products(first, last, out); });
  }

  /// Own partial sums of the square of |A| |x| + |b| in free rows. Overwrites w.
  void sum_magnitudes(double* out) const {
    for (std::size_t i = 0; i < rows_; ++i)
      for (int c = 0; c < 3; ++c) me_.w[i][c] = std::abs(me_.rhs[i][c]);
    for (std::size_t i = 0; i < rows_; ++i)
      for (int k = 0; k < 9; ++k)
        me_.w[i][k / 3] += std::abs(me_.mesh.diagonal[i].e[k] * own_x(i)[k % 3]);
    add_magnitudes<T>(me_.mesh, me_.x, me_.w);
    if (me_.far.row_count > 0) add_magnitudes<T>(me_.far, me_.x, me_.w);
    if (!me_.contact.count.empty()) add_contact_magnitudes<T>(me_.contact, count(), me_.x, me_.w);
    for (std::size_t i = 0; i < rows_; ++i)
      if (fixed(i)) me_.w[i] = {};
    std::size_t n = static_cast<std::size_t>(begin_) / step_;
    for (std::size_t row = 0; row < rows_; row += step_, ++n) {
      const std::size_t count = 3 * std::min(step_, rows_ - row);
      out[3 * n] = dot_block(me_.w[row].e, me_.w[row].e, count);
      out[3 * n + 1] = out[3 * n + 2] = 0;
    }
  }

  /// d = sums of all ranks' partial sums, pairwise; the shape depends on their number alone.
  /// @param all [3 * partials()] used up
  void tree(double* all, double d[3]) const {
    for (std::size_t stride = 1; stride < partials_; stride *= 2)
      for (std::size_t n = 0; n + stride < partials_; n += 2 * stride)
        for (std::size_t k = 0; k < 3; ++k) all[3 * n + k] += all[3 * (n + stride) + k];
    for (std::size_t k = 0; k < 3; ++k) d[k] = partials_ > 0 ? all[k] : 0;
  }

 private:
  bool fixed(std::size_t row) const {
    return me_.fixed[static_cast<std::size_t>(begin_) + row] != 0;
  }
  Vec3<T>& own_u(std::size_t row) const { return me_.u[static_cast<std::size_t>(begin_) + row]; }
  Vec3<T>& own_x(std::size_t row) const { return me_.x[static_cast<std::size_t>(begin_) + row]; }

  template <bool pulled>
  void multiply_range(const RowRange& range, Span<const Vec3<T>> v) const {
    multiply_mesh<T>(me_, range, begin_, v, me_.w);
    if (!me_.contact.count.empty())
      add_contact_rows<pulled>(me_.contact, range.first, range.last, v.data()->e, me_.w.data());
    for (auto i = static_cast<std::size_t>(range.first); i < static_cast<std::size_t>(range.last);
         ++i)
      if (fixed(i)) me_.w[i] = {};
  }

  /// Calls use(first, last) for the rows of each reduction block. No domain crosses its bounds.
  template <class Use>
  void for_each_block(const Use& use) const {
    for (std::size_t row = 0; row < rows_; row += step_) use(row, std::min(row + step_, rows_));
  }

  /// @tparam first_step p and s are uninitialised
  template <bool first_step>
  void step(T alpha, T beta, std::size_t first, std::size_t last) const {
    const std::size_t count = 3 * (last - first);
    const auto along = [=](const T* by, T* direction, T* to, T factor) {
      constexpr auto width = static_cast<std::size_t>(Simd<T>::width);
      std::size_t n = 0;
      for (; n + width <= count; n += width) {
        auto d = load_values(by + n);
        if constexpr (!first_step) d += beta * load_values(direction + n);
        store_values(d, direction + n);
        store_values(load_values(to + n) + factor * d, to + n);
      }
      for (; n < count; ++n) {
        direction[n] = first_step ? by[n] : by[n] + beta * direction[n];
        to[n] += factor * direction[n];
      }
    };
    along(own_u(first).e, me_.p[first].e, own_x(first).e, alpha);
    along(me_.w[first].e, me_.s[first].e, me_.r[first].e, -alpha);
  }

  void precondition(std::size_t first, std::size_t last) const {
    // Blocks are symmetric: their rows are their columns. A store writes one number too many, which
    // the next store replaces.
    std::size_t i = first;
    for (; i + 1 < last; ++i) {
      const T* block = me_.inverse.value.data() + 9 * i;
      const Vec3<T>& r = me_.r[i];
      store_values(
          load_vector(block) * r[0] + load_vector(block + 3) * r[1] + load_vector(block + 6) * r[2],
          own_u(i).e);
    }
    if (i < last) own_u(i) = me_.inverse.load(static_cast<Index>(i)) * me_.r[i];
  }

  void sum_products(std::size_t first, std::size_t last, double* out) const {
    const std::size_t n = (static_cast<std::size_t>(begin_) + first) / step_;
    const std::size_t count = 3 * (last - first);
    const T* r = me_.r[first].e;
    const T* u = own_u(first).e;
    out[3 * n] = dot_block(r, u, count);
    out[3 * n + 1] = dot_block(me_.w[first].e, u, count);
    out[3 * n + 2] = dot_block(r, r, count);
  }

  /// u += weight R^T (R A R^T)^-1 R r in rows [first, last), domain by domain.
  void correct(std::size_t first, std::size_t last) const {
    if (me_.fine.aggregates == schwarz_aggregates_max)
      correct(me_.fine, first, last, multiply_whole_blocks<T>);
    else if (me_.fine.aggregates > 0)
      correct(me_.fine, first, last, [this](const T* inverse, const T* x, T* y) {
        const Index n = me_.fine.aggregates;
        for (Index a = 0; a < n; ++a) {
          const Vec3<T> row = SymmetricBlocks::multiply_row(inverse, n, a, x);
          for (int c = 0; c < 3; ++c) y[3 * a + c] = row[c];
        }
      });
    if (me_.wide.aggregates == 0) return;
    correct(me_.wide, first, last, [size = me_.wide.size()](const T* inverse, const T* x, T* y) {
      for (Index k = 0; k < size; ++k)
        for (Index i = 0; i < size; ++i) y[i] += inverse[k * size + i] * x[k];
    });
  }

  /// @param multiply (inverse, x, y) makes y = inverse x of a domain, y being zero before
  template <class Level, class Multiply>
  void correct(const Level& level, std::size_t first_row, std::size_t last_row,
               const Multiply& multiply) const {
    const auto step = static_cast<std::size_t>(level.domain_rows());
    const auto numbers = static_cast<std::size_t>(level.domain_numbers());
    const auto rows = std::size_t{1} << level.shift;  // of an aggregate
    const T* inverse = level.inverse.data() + first_row / step * numbers;
    const unsigned char* fixed = me_.fixed.data() + begin_;
    for (std::size_t first = first_row; first < last_row; first += step, inverse += numbers) {
      const std::size_t count = std::min(step, last_row - first);
      T sum[3 * schwarz_aggregates_max + 1] = {};
      std::size_t sums = 0;
      for (std::size_t begin = 0; begin < count; begin += rows, sums += 3)
        store_values(sum_of(me_.r.data() + first + begin, std::min(rows, count - begin)),
                     sum + sums);
      sum[sums] = T(0);  // the last store wrote a fourth number there
      T move[3 * schwarz_aggregates_max] = {};
      multiply(inverse, sum, move);
      for (std::size_t begin = 0, k = 0; begin < count; begin += rows, k += 3)
        add_to_all(static_cast<T>(schwarz_weight) * Vec3<T>{move[k], move[k + 1], move[k + 2]},
                   fixed + first + begin, std::min(rows, count - begin), &own_u(first + begin));
    }
  }

  const SolvePcgPart<T>& me_;
  Index begin_;
  std::size_t rows_;
  std::size_t step_;  ///< rows of a reduction block
  std::size_t partials_;
};

}  // namespace weft::pcg
