#include "weft/kernels/assemble/rest_shape_rows.hpp"

#include "host/exec/for_each.hpp"

namespace weft {

template <class T>
void run(OnHost, Queue& queue, const AssembleRestShapeRows<T>& args) {
  submit_for_each(queue, args, args.row_count, [](const AssembleRestShapeRows<T>& a, Index i) {
    assemble_rest_shape_rows(a, i);
  });
}

template void run(OnHost, Queue&, const AssembleRestShapeRows<float>&);
template void run(OnHost, Queue&, const AssembleRestShapeRows<double>&);

}  // namespace weft
