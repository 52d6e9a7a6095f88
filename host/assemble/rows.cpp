#include "weft/kernels/assemble/rows.hpp"

#include "host/exec/for_each.hpp"

namespace weft {

template <class T>
void run(OnHost, Queue& queue, const AssembleRows<T>& args) {
  submit_for_each(queue, args, args.matrix.row_count,
                  [](const AssembleRows<T>& a, Index i) { assemble_row(a, i); });
}

template void run(OnHost, Queue&, const AssembleRows<float>&);
template void run(OnHost, Queue&, const AssembleRows<double>&);

}  // namespace weft
