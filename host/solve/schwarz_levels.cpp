#include "weft/kernels/solve/schwarz_levels.hpp"

#include <algorithm>
#include <cstring>
#include <type_traits>

#include "host/exec/host_device.hpp"
#include "host/solve/galerkin_matrix.hpp"

namespace weft {
namespace {

/// Rows of both levels' matrices, a fine domain at a time.
template <class T>
class DomainInverter {
 public:
  explicit DomainInverter(const SolveSchwarzLevels<T>& args) noexcept
      : a_(args), sum_(args.fine.size()) {}

  void run() noexcept {
    const Index step = a_.fine.domain_rows();
    T* out = a_.fine.inverse.data();
    double* wide_sum = a_.wide_sum.data();
    for (first_ = 0; first_ < a_.mesh.row_count; first_ += step) {
      last_ = std::min(a_.mesh.row_count, first_ + step);
      begin_ = has_wide() ? first_ / a_.wide.domain_rows() * a_.wide.domain_rows() : first_;
      sum_.clear();
      for (Mat3<double>& block : left_) block = {};
      add_diagonal();
      add_entries(a_.mesh, [this](Index row, Index column, const T* value, Index stride) {
        add_block(row, column, [=](int k) { return value[k * stride]; });
      });
      if (a_.far.row_count > 0)
        add_entries(a_.far, [this](Index row, Index column, const T* value, Index) {
          add_scalar(row, column, static_cast<double>(*value));
        });
      add_contacts();
      if (has_wide()) {
        left_[(first_ - begin_) >> a_.wide.shift] = sum_.total();
        std::memcpy(wide_sum, left_, sizeof left_);
        wide_sum += FineLevel<T>::wide_sums;
      }
      sum_.invert();
      sum_.store_blocks(out);
      out += a_.fine.domain_numbers();
    }
    if (has_wide()) invert_wide();
  }

 private:
  bool has_wide() const noexcept { return a_.wide.aggregates > 0; }
  bool fixed(Index row) const noexcept { return a_.fixed.data()[a_.row_begin + row] != 0; }
  Index aggregate(Index row) const noexcept { return (row - first_) >> a_.fine.shift; }
  /// Whether a column counts: a row of this domain, or of one before it in the wide level's, that
  /// moves.
  bool has(Index row) const noexcept { return row >= begin_ && row < last_ && !fixed(row); }

  template <class Component>
  void add_block(Index row, Index column, const Component& component) noexcept {
    if (column >= first_) return sum_.add_block(aggregate(row), aggregate(column), component);
    Mat3<double>& block = left_[(column - begin_) >> a_.wide.shift];
    for (int k = 0; k < 9; ++k) block.e[k] += static_cast<double>(component(k));
  }
  void add_scalar(Index row, Index column, double value) noexcept {
    if (column >= first_) return sum_.add_scalar(aggregate(row), aggregate(column), value);
    Mat3<double>& block = left_[(column - begin_) >> a_.wide.shift];
    for (int k = 0; k < 3; ++k) block(k, k) += value;
  }

  void add_diagonal() noexcept {
    for (Index row = first_; row < last_; ++row)
      if (!fixed(row))
        add_block(row, row, [&](int k) { return a_.mesh.diagonal.data()[row].e[k]; });
  }

  /// Slice by slice, so that the lanes of a slot are read together. Domains are whole slices.
  template <class Matrix, class Add>
  void add_entries(const Matrix& m, const Add& add) noexcept {
    constexpr Index components = std::is_same_v<Matrix, BlockEll<T>> ? 9 : 1;
    for (Index begin = first_; begin < last_; begin += m.slice) {
      const Index lanes = std::min(m.slice, last_ - begin);
      const Offset* offset = m.slice_offset.data() + begin / m.slice;
      for (Offset slot = offset[0]; slot < offset[1]; ++slot) {
        const Index* column = m.column.data() + slot * m.slice;
        const T* value = m.value.data() + slot * components * m.slice;
        for (Index lane = 0; lane < lanes; ++lane)
          if (const Index other = column[lane] - a_.row_begin; has(other) && !fixed(begin + lane))
            add(begin + lane, other, value + lane, m.slice);
      }
    }
  }

  void add_contacts() noexcept {
    if (a_.contact.count.empty()) return;
    for (Index row = first_; row < last_; ++row)
      for (Index e = a_.contact.end_offset.data()[row]; e < a_.contact.end_offset.data()[row + 1];
           ++e)
        add_link(row, a_.contact.link.data()[a_.contact.end.data()[e].link]);
  }
  /// Adds a link as a whole where it is met in the first row of the domain that it moves.
  void add_link(Index row, const ContactOperatorEntry<T>& link) noexcept {
    Corners own;   // by the aggregates of this domain
    Corners left;  // by those of the wide level before it
    Index first = last_;
    T all = T(0);
    for (int n = 0; n < 4; ++n) {
      const Index r = link.v[n] - a_.row_begin;
      const T weight = link.w[n];
      if (weight == T(0) || !has(r)) continue;
      if (r < first_) {
        left.add((r - begin_) >> a_.wide.shift, weight);
        continue;
      }
      if (r < row) return;
      first = std::min(first, r);
      all += weight;
      own.add(aggregate(r), weight);
    }
    if (first != row) return;
    for (int i = 0; i < own.count; ++i)
      for (int j = 0; j < own.count; ++j)
        if (own.place[j] <= own.place[i]) {
          const T weight = own.weight[i] * own.weight[j];
          sum_.add_block(own.place[i], own.place[j],
                         [&](int k) { return weight * link.component(k); });
        }
    for (int n = 0; n < left.count; ++n) {
      const T weight = all * left.weight[n];
      for (int k = 0; k < 9; ++k)
        left_[left.place[n]].e[k] += static_cast<double>(weight * link.component(k));
    }
  }

  /// Corners of a link, those of an aggregate as one.
  struct Corners {
    Index place[4];
    T weight[4];
    int count = 0;

    void add(Index where, T by) noexcept {
      for (int n = 0; n < count; ++n)
        if (place[n] == where) {
          weight[n] += by;
          return;
        }
      place[count] = where;
      weight[count++] = by;
    }
  };

  void invert_wide() const noexcept {
    GalerkinMatrix sum(a_.wide.size());
    T* out = a_.wide.inverse.data();
    const double* block = a_.wide_sum.data();
    for (Index left = a_.fine.domains(a_.mesh.row_count); left > 0; left -= a_.wide.aggregates) {
      sum.clear();
      for (Index i = 0; i < std::min(left, a_.wide.aggregates);
           ++i, block += FineLevel<T>::wide_sums)
        for (Index j = 0; j <= i; ++j) sum.add_block(i, j, [&](int k) { return block[9 * j + k]; });
      sum.invert();
      sum.store_dense(out);
      out += a_.wide.domain_numbers();
    }
  }

  const SolveSchwarzLevels<T>& a_;
  Index first_ = 0, last_ = 0;  ///< rows of the fine domain
  Index begin_ = 0;             ///< of the wide domain around it, if there is one
  GalerkinMatrix sum_;
  Mat3<double> left_[schwarz_aggregates_max];  ///< row of the wide level's blocks
};

}  // namespace

template <class T>
void run(OnHost, Queue& queue, const SolveSchwarzLevels<T>& args) {
  submit_host(queue, [args] { DomainInverter<T>(args).run(); });
}

template void run(OnHost, Queue&, const SolveSchwarzLevels<float>&);
template void run(OnHost, Queue&, const SolveSchwarzLevels<double>&);

}  // namespace weft
