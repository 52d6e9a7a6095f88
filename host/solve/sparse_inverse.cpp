#include "weft/kernels/solve/sparse_inverse.hpp"

#include "host/exec/for_each.hpp"

namespace weft {

template <class T>
void run(OnHost, Queue& queue, const SolveSparseInverse<T>& args) {
  submit_for_each(queue, args, args.factor.row_count,
                  [](const SolveSparseInverse<T>& a, Index i) { sparse_inverse_row(a, i); });
}

template void run(OnHost, Queue&, const SolveSparseInverse<float>&);
template void run(OnHost, Queue&, const SolveSparseInverse<double>&);

}  // namespace weft
