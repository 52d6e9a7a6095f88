#include "weft/kernels/solve/schwarz_level.hpp"

#include <algorithm>
#include <type_traits>

#include "host/exec/host_device.hpp"
#include "host/solve/galerkin_matrix.hpp"

namespace weft {
namespace {

/// The matrices of a level's domains.
template <class T>
class DomainInverter {
 public:
  explicit DomainInverter(const SolveSchwarzLevel<T>& args) noexcept
      : a_(args), sum_(args.level.size()) {}

  void run() noexcept {
    const Index rows = a_.mesh.row_count;
    const Index step = a_.level.domain_rows();
    T* out = a_.level.inverse.data();
    for (first_ = 0; first_ < rows; first_ += step, out += a_.level.size() * a_.level.size()) {
      last_ = std::min(rows, first_ + step);
      sum_.clear();
      add_diagonal();
      add_entries(a_.mesh, [this](Index row, Index column, const T* value, Index stride) {
        sum_.add_block(row, column, [=](int k) { return value[k * stride]; });
      });
      if (a_.far.row_count > 0)
        add_entries(a_.far, [this](Index row, Index column, const T* value, Index) {
          sum_.add_scalar(row, column, static_cast<double>(*value));
        });
      add_contacts();
      sum_.invert();
      sum_.store(out);
    }
  }

 private:
  bool fixed(Index row) const noexcept { return a_.fixed.data()[a_.row_begin + row] != 0; }
  Index aggregate(Index row) const noexcept { return (row - first_) >> a_.level.shift; }
  /// Whether a column is a row of this domain that moves.
  bool has(Index row) const noexcept { return row >= first_ && row < last_ && !fixed(row); }

  void add_diagonal() noexcept {
    for (Index row = first_; row < last_; ++row)
      if (!fixed(row))
        sum_.add_block(aggregate(row), aggregate(row),
                       [&](int k) { return a_.mesh.diagonal.data()[row].e[k]; });
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
            add(aggregate(begin + lane), aggregate(other), value + lane, m.slice);
      }
    }
  }

  void add_contacts() noexcept {
    for (Index row = first_; row < last_; ++row)
      if (!fixed(row))
        visit_contact_entries(a_.contact, row,
                              [&](Index vertex, T weight, const ContactOperatorEntry<T>& link) {
                                if (const Index other = vertex - a_.row_begin; has(other))
                                  sum_.add_block(aggregate(row), aggregate(other),
                                                 [&](int k) { return weight * link.component(k); });
                              });
  }

  const SolveSchwarzLevel<T>& a_;
  Index first_ = 0, last_ = 0;
  GalerkinMatrix sum_;
};

}  // namespace

template <class T>
void run(OnHost, Queue& queue, const SolveSchwarzLevel<T>& args) {
  submit_host(queue, [args] { DomainInverter<T>(args).run(); });
}

template void run(OnHost, Queue&, const SolveSchwarzLevel<float>&);
template void run(OnHost, Queue&, const SolveSchwarzLevel<double>&);

}  // namespace weft
