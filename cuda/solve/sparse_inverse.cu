#include "weft/kernels/solve/sparse_inverse.hpp"

#include "cuda/exec/launch.cuh"

namespace weft {

struct FactorBody {
  template <class T>
  WEFT_HD void operator()(const SolveFactor<T>& a, Index i) const noexcept {
    factor_row(a, i);
  }
};

template <class T>
void run(OnCuda, Queue& queue, const SolveFactor<T>& args) {
  launch_for_each(queue, args, args.factor.row_count, FactorBody{});
}

template void run(OnCuda, Queue&, const SolveFactor<float>&);
template void run(OnCuda, Queue&, const SolveFactor<double>&);

}  // namespace weft
