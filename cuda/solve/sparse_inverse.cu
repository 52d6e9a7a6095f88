#include "weft/kernels/solve/sparse_inverse.hpp"

#include "cuda/exec/launch.cuh"

namespace weft {

struct SparseInverseBody {
  template <class T>
  WEFT_HD void operator()(const SolveSparseInverse<T>& a, Index i) const noexcept {
    sparse_inverse_row(a, i);
  }
};

template <class T>
void run(OnCuda, Queue& queue, const SolveSparseInverse<T>& args) {
  launch_for_each(queue, args, args.factor.row_count, SparseInverseBody{});
}

template void run(OnCuda, Queue&, const SolveSparseInverse<float>&);
template void run(OnCuda, Queue&, const SolveSparseInverse<double>&);

}  // namespace weft
