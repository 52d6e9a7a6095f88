#include "weft/kernels/solve/pcg.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <vector>

#include "host/exec/host_device.hpp"
#include "host/solve/pcg_rows.hpp"
#include "host/solve/tracked.hpp"
#include "weft/exec/spin.hpp"

namespace weft {
namespace {

/// Blocks until `flag` has reached `epoch` (counters may wrap around).
void wait_for(std::uint32_t& flag, std::uint32_t epoch) {
  const std::atomic_ref<std::uint32_t> atomic(flag);
  std::uint32_t seen = atomic.load(std::memory_order_acquire);
  while (static_cast<std::int32_t>(seen - epoch) < 0) {
    wait_for_change(atomic, seen);
    seen = atomic.load(std::memory_order_acquire);
  }
}

void publish(std::uint32_t& flag, std::uint32_t epoch) {
  const std::atomic_ref<std::uint32_t> atomic(flag);
  atomic.store(epoch, std::memory_order_release);
  atomic.notify_all();
}

/// One rank's share of the collective solve.
template <class T>
class PcgRank {
 public:
  explicit PcgRank(const SolvePcg<T>& args)
      : a_(args),
        me_(args.parts[static_cast<std::size_t>(args.rank)]),
        ranks_(args.parts.size()),
        rows_(a_, me_),
        tracked_(me_.tracked),
        vector_epoch_(args.epoch),
        partial_epoch_(args.epoch) {}

  void solve() {
    PcgScalars<T> scalars;
    double d[3];
    if (a_.resume) scalars.resume(a_, me_.status[0]);
    while (scalars.status.paused == 0) {
      if (!scalars.running) {
        if (scalars.asks_for_magnitude()) scalars.magnitude = magnitude();
        true_residual();
        multiply_and_reduce(d);
        if (!scalars.restart(a_, d)) break;
      }
      while (scalars.running) {
        rows_.update(static_cast<T>(scalars.alpha), static_cast<T>(scalars.beta));
        multiply_and_reduce(d);
        scalars.advance(a_, d);
      }
    }
    me_.status[0] = scalars.status;
  }

 private:
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

  /// 2-norm of |A| |x| + |b| in free rows.
  double magnitude() {
    exchange(&SolvePcgPart<T>::x);
    ++partial_epoch_;
    rows_.sum_magnitudes(own_partials());
    double d[3];
    join_partials(d);
    return std::sqrt(d[0]);
  }

  /// r = b - A x in free rows, u = P r.
  void true_residual() {
    if (tracked_.any()) tracked_.meet(me_.x);
    exchange(&SolvePcgPart<T>::x);
    rows_.multiply(me_.x);
    rows_.take_residual();
    if (tracked_.any()) {
      tracked_.project_residual(me_.r);
      rows_.precondition();
    }
    rows_.correct();
  }

  std::size_t parity() const { return (partial_epoch_ - a_.epoch) % 2; }
  double* own_partials() const { return me_.partial.data() + parity() * 3 * rows_.partials(); }

  /// w = A u, and d = (r, u), (w, u), (r, r) over all ranks.
  void multiply_and_reduce(double d[3]) {
    if (tracked_.any()) tracked_.project_direction(me_.u);
    exchange(&SolvePcgPart<T>::u);
    ++partial_epoch_;
    rows_.multiply_and_sum(own_partials());
    if (tracked_.any()) {
      tracked_.project_residual(me_.w);
      rows_.sum_products(own_partials());
    }
    // One rank decides, and all see it in the same sum: they must leave the solve together.
    if (a_.rank == 0 && rows_.count() > 0 && a_.stop != nullptr &&
        a_.stop->load(std::memory_order_relaxed))
      std::fill_n(own_partials(), 3, std::numeric_limits<double>::quiet_NaN());
    join_partials(d);
  }

  void join_partials(double d[3]) {
    gather();
    rows_.tree(all_.data(), d);
  }

  /// Makes own partials visible and fetches all. Two sets are in use by turns: nobody writes a set
  /// again before every peer has passed the reduction in between.
  void gather() {
    publish(me_.ready[1], partial_epoch_);
    all_.resize(3 * rows_.partials());
    const std::size_t step = rows_.partial_rows();
    for (std::size_t peer = 0; peer < ranks_; ++peer) {
      wait_for(a_.parts[peer].ready[1], partial_epoch_);
      const std::size_t first = (static_cast<std::size_t>(a_.row_begin[peer]) + step - 1) / step;
      const std::size_t last = (static_cast<std::size_t>(a_.row_begin[peer + 1]) + step - 1) / step;
      const double* theirs = a_.parts[peer].partial.data() + parity() * 3 * rows_.partials();
      for (std::size_t n = 3 * first; n < 3 * last; ++n) all_[n] = theirs[n];
    }
  }

  const SolvePcg<T> a_;
  const SolvePcgPart<T>& me_;
  std::size_t ranks_;
  pcg::Rows<T> rows_;
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
