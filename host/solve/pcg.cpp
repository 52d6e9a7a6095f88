#include "weft/kernels/solve/pcg.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <type_traits>
#include <vector>

#include "host/exec/host_device.hpp"
#include "host/solve/mode_moves.hpp"
#include "host/solve/tracked.hpp"

namespace weft {
namespace {

constexpr Index lanes = host_slice;

void relax() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#endif
}

/// Blocks until `flag` has reached `epoch` (counters may wrap around).
void wait_for(std::uint32_t& flag, std::uint32_t epoch) {
  const std::atomic_ref<std::uint32_t> atomic(flag);
  std::uint32_t seen = atomic.load(std::memory_order_acquire);
  // A peer is a few microseconds behind as a rule: look again before going to sleep.
  for (int spin = 0; spin < 4000 && static_cast<std::int32_t>(seen - epoch) < 0; ++spin) {
    relax();
    seen = atomic.load(std::memory_order_acquire);
  }
  while (static_cast<std::int32_t>(seen - epoch) < 0) {
    atomic.wait(seen, std::memory_order_acquire);
    seen = atomic.load(std::memory_order_acquire);
  }
}

void publish(std::uint32_t& flag, std::uint32_t epoch) {
  const std::atomic_ref<std::uint32_t> atomic(flag);
  atomic.store(epoch, std::memory_order_release);
  atomic.notify_all();
}

/// y = rows of slice-8 matrix times u. One lane a row, so that the compiler can use vector
/// registers.
template <class T>
void multiply_mesh(const BlockEll<T>& m, Span<const Vec3<T>> u, Span<Vec3<T>> y) {
  const Index slices = (m.row_count + lanes - 1) / lanes;
  for (Index slice = 0; slice < slices; ++slice) {
    T sum[3][lanes] = {};
    for (Offset slot = m.slice_offset[static_cast<std::size_t>(slice)];
         slot < m.slice_offset[static_cast<std::size_t>(slice) + 1]; ++slot) {
      const Index* column = m.column.data() + slot * lanes;
      const T* value = m.value.data() + slot * 9 * lanes;
      T x[3][lanes];
      for (Index lane = 0; lane < lanes; ++lane) {
        const Vec3<T>& v = u.data()[column[lane]];
        x[0][lane] = v[0];
        x[1][lane] = v[1];
        x[2][lane] = v[2];
      }
      for (int i = 0; i < 3; ++i)
        for (Index lane = 0; lane < lanes; ++lane)
          sum[i][lane] += value[(3 * i) * lanes + lane] * x[0][lane] +
                          value[(3 * i + 1) * lanes + lane] * x[1][lane] +
                          value[(3 * i + 2) * lanes + lane] * x[2][lane];
    }
    const Index rows = std::min(lanes, m.row_count - slice * lanes);
    for (Index lane = 0; lane < rows; ++lane)
      y.data()[slice * lanes + lane] = {sum[0][lane], sum[1][lane], sum[2][lane]};
  }
}

/// y += rows of slice-8 matrix of multiples of the identity times u.
template <class T>
void multiply_far(const ScalarEll<T>& m, Span<const Vec3<T>> u, Span<Vec3<T>> y) {
  const Index slices = (m.row_count + lanes - 1) / lanes;
  for (Index slice = 0; slice < slices; ++slice) {
    T sum[3][lanes] = {};
    for (Offset slot = m.slice_offset[static_cast<std::size_t>(slice)];
         slot < m.slice_offset[static_cast<std::size_t>(slice) + 1]; ++slot) {
      const Index* column = m.column.data() + slot * lanes;
      const T* value = m.value.data() + slot * lanes;
      for (Index lane = 0; lane < lanes; ++lane) {
        const Vec3<T>& v = u.data()[column[lane]];
        for (int c = 0; c < 3; ++c) sum[c][lane] += value[lane] * v[c];
      }
    }
    const Index rows = std::min(lanes, m.row_count - slice * lanes);
    for (Index lane = 0; lane < rows; ++lane)
      y.data()[slice * lanes + lane] += Vec3<T>{sum[0][lane], sum[1][lane], sum[2][lane]};
  }
}

/// y += rows of slice-1 matrix times u.
template <class T>
void multiply_contact(const BlockEll<T>& m, Span<const Vec3<T>> u, Span<Vec3<T>> y) {
  for (Index row = 0; row < m.row_count; ++row) {
    Vec3<T> sum{};
    for (Offset e = m.slice_offset[static_cast<std::size_t>(row)];
         e < m.slice_offset[static_cast<std::size_t>(row) + 1]; ++e) {
      const T* b = m.value.data() + 9 * e;
      const Vec3<T>& x = u.data()[m.column.data()[e]];
      for (int i = 0; i < 3; ++i)
        sum[i] += b[3 * i] * x[0] + b[3 * i + 1] * x[1] + b[3 * i + 2] * x[2];
    }
    y.data()[row] += sum;
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

/// One rank's share of the collective solve.
template <class T>
class PcgRank {
 public:
  explicit PcgRank(const SolvePcg<T>& args)
      : a_(args),
        me_(args.parts[static_cast<std::size_t>(args.rank)]),
        ranks_(args.parts.size()),
        begin_(args.row_begin[static_cast<std::size_t>(args.rank)]),
        rows_(static_cast<std::size_t>(args.row_begin[static_cast<std::size_t>(args.rank) + 1] -
                                       begin_)),
        step_(static_cast<std::size_t>(std::min(args.partial_rows, pcg_partial_rows_max))),
        partials_(
            static_cast<std::size_t>(pcg_partials(args.row_begin[ranks_], args.partial_rows))),
        modes_(me_.modes, begin_, static_cast<Index>(rows_)),
        tracked_(me_.tracked),
        vector_epoch_(args.epoch),
        partial_epoch_(args.epoch) {}

  void solve() {
    PcgScalars<T> scalars;
    double d[3];
    while (true) {
      if (scalars.asks_for_magnitude()) scalars.magnitude = magnitude();
      true_residual();
      reduce(d);
      if (!scalars.restart(a_, d)) break;
      while (scalars.running) {
        update(static_cast<T>(scalars.alpha), static_cast<T>(scalars.beta));
        multiply(&SolvePcgPart<T>::u);
        reduce(d);
        scalars.advance(a_, d);
      }
    }
    me_.status[0] = scalars.status;
  }

 private:
  bool fixed(std::size_t row) const {
    return me_.fixed[static_cast<std::size_t>(begin_) + row] != 0;
  }
  Vec3<T>& own_u(std::size_t row) const { return me_.u[static_cast<std::size_t>(begin_) + row]; }
  Vec3<T>& own_x(std::size_t row) const { return me_.x[static_cast<std::size_t>(begin_) + row]; }

  /// Makes own rows of `vector` visible and fetches its ghosts. Own rows may be written again once
  /// a reduction has passed: by then every peer has fetched.
  void exchange(Span<Vec3<T>> SolvePcgPart<T>::*vector) {
    ++vector_epoch_;
    publish(me_.ready[0], vector_epoch_);
    Vec3<T>* mine = (me_.*vector).data();
    for (std::size_t peer = 0; peer < ranks_; ++peer) {
      const auto first = static_cast<std::size_t>(me_.ghost_offset[peer]);
      const auto last = static_cast<std::size_t>(me_.ghost_offset[peer + 1]);
      if (first == last) continue;
      wait_for(a_.parts[peer].ready[0], vector_epoch_);
      const Vec3<T>* theirs = (a_.parts[peer].*vector).data();
      for (std::size_t g = first; g < last; ++g)
        mine[me_.ghost.data()[g]] = theirs[me_.ghost.data()[g]];
    }
  }

  /// w = A vector in free rows, zero in fixed ones.
  void multiply(Span<Vec3<T>> SolvePcgPart<T>::*vector) {
    exchange(vector);
    multiply_mesh<T>(me_.mesh, me_.*vector, me_.w);
    if (me_.far.row_count > 0) multiply_far<T>(me_.far, me_.*vector, me_.w);
    if (me_.contact.row_count > 0) multiply_contact<T>(me_.contact, me_.*vector, me_.w);
    for (std::size_t i = 0; i < rows_; ++i)
      if (fixed(i)) me_.w[i] = {};
    if (tracked_.any() && vector == &SolvePcgPart<T>::u) tracked_.project_residual(me_.w);
  }

  /// 2-norm of |A| |x| + |b| in free rows.
  double magnitude() {
    exchange(&SolvePcgPart<T>::x);
    for (std::size_t i = 0; i < rows_; ++i)
      for (int c = 0; c < 3; ++c) me_.w[i][c] = std::abs(me_.rhs[i][c]);
    add_magnitudes<T>(me_.mesh, me_.x, me_.w);
    if (me_.far.row_count > 0) add_magnitudes<T>(me_.far, me_.x, me_.w);
    if (me_.contact.row_count > 0) add_magnitudes<T>(me_.contact, me_.x, me_.w);
    for (std::size_t i = 0; i < rows_; ++i)
      if (fixed(i)) me_.w[i] = {};
    ++partial_epoch_;
    double* out = me_.partial.data() + parity() * 3 * partials_;
    std::size_t n = static_cast<std::size_t>(begin_) / step_;
    for (std::size_t row = 0; row < rows_; row += step_, ++n) {
      const std::size_t count = 3 * std::min(step_, rows_ - row);
      out[3 * n] = dot_block(me_.w[row].e, me_.w[row].e, count);
      out[3 * n + 1] = out[3 * n + 2] = 0;
    }
    double d[3];
    join_partials(d);
    return std::sqrt(d[0]);
  }

  /// r = b - A x in free rows, u = P r, w = A u.
  void true_residual() {
    if (tracked_.any()) tracked_.meet(me_.x);
    multiply(&SolvePcgPart<T>::x);
    for (std::size_t i = 0; i < rows_; ++i)
      me_.r[i] = fixed(i) ? Vec3<T>{} : me_.rhs[i] - me_.w[i];
    if (tracked_.any()) tracked_.project_residual(me_.r);
    for (std::size_t i = 0; i < rows_; ++i) own_u(i) = me_.inverse[i] * me_.r[i];
    if (modes_.any()) {
      begin_sums(&SolvePcgPart<T>::r);
      gather();
      modes_.restart();
    }
    correct_all();
    multiply(&SolvePcgPart<T>::u);
  }

  std::size_t parity() const { return (partial_epoch_ - a_.epoch) % 2; }

  /// Starts another epoch of partial sums, with those of the modes of own rows of `vector`.
  void begin_sums(Span<Vec3<T>> SolvePcgPart<T>::*vector) {
    ++partial_epoch_;
    if (modes_.any()) modes_.sum(me_.*vector, parity());
  }

  /// d = (r, u), (w, u), (r, r) over all ranks.
  void reduce(double d[3]) {
    begin_sums(&SolvePcgPart<T>::w);
    double* out = me_.partial.data() + parity() * 3 * partials_;
    const std::size_t first_partial = static_cast<std::size_t>(begin_) / step_;
    for (std::size_t row = 0, n = first_partial; row < rows_; row += step_, ++n) {
      const std::size_t count = 3 * std::min(step_, rows_ - row);
      const T* r = me_.r[row].e;
      const T* u = own_u(row).e;
      out[3 * n] = dot_block(r, u, count);
      out[3 * n + 1] = dot_block(me_.w[row].e, u, count);
      out[3 * n + 2] = dot_block(r, r, count);
    }
    join_partials(d);
  }

  void join_partials(double d[3]) {
    gather();
    tree(d);
  }

  /// Makes own partials visible and fetches all. Two sets are in use by turns: nobody writes a set
  /// again before every peer has passed the reduction in between.
  void gather() {
    publish(me_.ready[1], partial_epoch_);
    all_.resize(3 * partials_);
    for (std::size_t peer = 0; peer < ranks_; ++peer) {
      wait_for(a_.parts[peer].ready[1], partial_epoch_);
      const std::size_t first = (static_cast<std::size_t>(a_.row_begin[peer]) + step_ - 1) / step_;
      const std::size_t last =
          (static_cast<std::size_t>(a_.row_begin[peer + 1]) + step_ - 1) / step_;
      const double* theirs = a_.parts[peer].partial.data() + parity() * 3 * partials_;
      for (std::size_t n = 3 * first; n < 3 * last; ++n) all_[n] = theirs[n];
      if (modes_.any()) modes_.take(a_.parts[peer].modes, parity(), first, last);
    }
  }

  /// Sums the partials pairwise; the shape depends on their number alone.
  void tree(double d[3]) {
    for (std::size_t stride = 1; stride < partials_; stride *= 2)
      for (std::size_t n = 0; n + stride < partials_; n += 2 * stride)
        for (std::size_t k = 0; k < 3; ++k) all_[3 * n + k] += all_[3 * (n + stride) + k];
    for (std::size_t k = 0; k < 3; ++k) d[k] = partials_ > 0 ? all_[k] : 0;
  }

  /// One step along the direction that u gives, then u = P r.
  void update(T alpha, T beta) {
    for (std::size_t i = 0; i < rows_; ++i) {
      const Vec3<T> p = own_u(i) + (beta == T(0) ? Vec3<T>{} : beta * me_.p[i]);
      const Vec3<T> s = me_.w[i] + (beta == T(0) ? Vec3<T>{} : beta * me_.s[i]);
      const Vec3<T> r = me_.r[i] - alpha * s;
      me_.p[i] = p;
      me_.s[i] = s;
      me_.r[i] = r;
      own_x(i) += alpha * p;
      own_u(i) = me_.inverse[i] * r;
    }
    if (modes_.any()) modes_.advance(static_cast<double>(alpha), static_cast<double>(beta));
    correct_all();
  }

  /// Adds to u what all levels of aggregates make of r.
  void correct_all() {
    for (const CoarseLevel<T>& level : me_.coarse) correct(level);
    if (modes_.any()) modes_.correct(me_.r, me_.fixed, me_.u);
    if (tracked_.any()) tracked_.project_direction(me_.u);
  }

  /// u += weight R^T (R A R^T)^-1 R r, domain by domain.
  void correct(const CoarseLevel<T>& level) {
    if (level.aggregates < 2) return;
    const auto step = static_cast<std::size_t>(level.domain_rows());
    const auto size = static_cast<std::size_t>(level.size());
    const T* inverse = level.inverse.data();
    for (std::size_t first = 0; first < rows_; first += step, inverse += size * size) {
      const std::size_t count = std::min(step, rows_ - first);
      T sum[3 * coarse_aggregates_max] = {};
      for (std::size_t i = 0; i < count; ++i)
        for (std::size_t c = 0; c < 3; ++c)
          sum[3 * (i >> level.shift) + c] += me_.r.data()[first + i].e[c];
      T move[3 * coarse_aggregates_max] = {};
      for (std::size_t k = 0; k < size; ++k)
        for (std::size_t i = 0; i < size; ++i) move[i] += inverse[k * size + i] * sum[k];
      for (std::size_t i = 0; i < count; ++i)
        if (!fixed(first + i))
          for (std::size_t c = 0; c < 3; ++c)
            own_u(first + i).e[c] +=
                static_cast<T>(coarse_weight) * move[3 * (i >> level.shift) + c];
    }
  }

  const SolvePcg<T> a_;
  const SolvePcgPart<T>& me_;
  std::size_t ranks_;
  Index begin_;
  std::size_t rows_;
  std::size_t step_;  ///< rows of a partial sum
  std::size_t partials_;
  ModeMoves<T> modes_;
  Tracked tracked_;
  std::uint32_t vector_epoch_;
  std::uint32_t partial_epoch_;
  std::vector<double> all_;
};

}  // namespace

template <class T>
void run(OnHost, Queue& queue, const SolvePcg<T>& args) {
  submit_host(queue, [args] { PcgRank<T>(args).solve(); });
}

template void run(OnHost, Queue&, const SolvePcg<float>&);
template void run(OnHost, Queue&, const SolvePcg<double>&);

}  // namespace weft
