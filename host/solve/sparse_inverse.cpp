#include "weft/kernels/solve/sparse_inverse.hpp"

#include "host/exec/for_each.hpp"

namespace weft {

template <class T>
void run(OnHost, Queue& queue, const SolveFactor<T>& args) {
  submit_for_each(queue, args, args.factor.row_count,
                  [](const SolveFactor<T>& a, Index i) { factor_row(a, i); });
}

template void run(OnHost, Queue&, const SolveFactor<float>&);
template void run(OnHost, Queue&, const SolveFactor<double>&);

}  // namespace weft
