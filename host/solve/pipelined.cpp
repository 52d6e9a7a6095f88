#include "weft/kernels/solve/pipelined.hpp"

#include <algorithm>
#include <vector>

#include "host/exec/host_device.hpp"
#include "host/solve/pcg_rows.hpp"

namespace weft {
namespace {

/// One piece of one rank's work.
template <class T>
class PipelinedRank {
 public:
  explicit PipelinedRank(const SolvePipelined<T>& args)
      : a_(args), state_(args.state[0]), rows_(a_.solve, a_.part) {}

  void work() {
    if (a_.only_if_running && !state_.scalars.running) return;
    switch (a_.work) {
      case PipelinedWork::begin:
        return begin();
      case PipelinedWork::multiply_x:
        return multiply(a_.part.x);
      case PipelinedWork::multiply_u:
        return multiply(a_.part.u);
      case PipelinedWork::residual:
        rows_.take_residual();
        return rows_.correct();
      case PipelinedWork::update:
        return rows_.update(static_cast<T>(state_.scalars.alpha),
                            static_cast<T>(state_.scalars.beta));
      case PipelinedWork::products:
        return rows_.sum_products(a_.part.partial.data());
      case PipelinedWork::magnitudes:
        return rows_.sum_magnitudes(a_.part.partial.data());
      case PipelinedWork::take_magnitude:
      case PipelinedWork::restart:
      case PipelinedWork::advance:
        return take_sums();
    }
  }

 private:
  void begin() {
    state_ = {};
    if (a_.solve.resume) state_.scalars.resume(a_.solve, a_.part.status[0]);
    for (Index group = 0; group < pipelined_groups(rows_.count()); ++group) {
      int stage = 0;
      const Index first = group * pipelined_group_rows;
      for (Index row = first; row < std::min(rows_.count(), first + pipelined_group_rows); ++row)
        stage = std::max(stage, last_arrival(a_, row));
      a_.group_stage[static_cast<std::size_t>(group)] = static_cast<unsigned char>(stage);
    }
  }

  void multiply(Span<const Vec3<T>> vector) {
    for (Index group = 0; group < pipelined_groups(rows_.count()); ++group) {
      if (a_.group_stage[static_cast<std::size_t>(group)] != a_.stage) continue;
      const Index first = group * pipelined_group_rows;
      rows_.multiply({first, std::min(rows_.count(), first + pipelined_group_rows)}, vector);
    }
  }

  void take_sums() {
    const double* partial = a_.part.partial.data();
    std::vector<double> all(partial, partial + 3 * rows_.partials());
    double d[3];
    rows_.tree(all.data(), d);
    if (state_.take(a_, d)) a_.part.status[0] = state_.scalars.status;
  }

  const SolvePipelined<T>& a_;
  PipelinedState<T>& state_;
  pcg::Rows<T> rows_;
};

}  // namespace

template <class T>
void run(OnHost, Queue& queue, const SolvePipelined<T>& args) {
  submit_host(queue, [args] { PipelinedRank<T>(args).work(); });
}

template void run(OnHost, Queue&, const SolvePipelined<float>&);
template void run(OnHost, Queue&, const SolvePipelined<double>&);

}  // namespace weft
