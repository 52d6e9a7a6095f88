#include "weft/kernels/assemble/rest_shape_rows.hpp"

#include "host/exec/for_each.hpp"

namespace weft {

template <class T>
void run(OnHost, Queue& queue, const AssembleShapeRows<T>& args) {
  submit_for_each(queue, args, args.row_count,
                  [](const AssembleShapeRows<T>& a, Index i) { assemble_shape_rows(a, i); });
}

template void run(OnHost, Queue&, const AssembleShapeRows<float>&);
template void run(OnHost, Queue&, const AssembleShapeRows<double>&);

}  // namespace weft
