#include "weft/kernels/assemble/rest_shape_rows.hpp"

#include "cuda/exec/launch.cuh"

namespace weft {

struct AssembleShapeRowsBody {
  template <class T>
  WEFT_HD void operator()(const AssembleShapeRows<T>& a, Index i) const noexcept {
    assemble_shape_rows(a, i);
  }
};

template <class T>
void run(OnCuda, Queue& queue, const AssembleShapeRows<T>& args) {
  launch_for_each(queue, args, args.row_count, AssembleShapeRowsBody{});
}

template void run(OnCuda, Queue&, const AssembleShapeRows<float>&);
template void run(OnCuda, Queue&, const AssembleShapeRows<double>&);

}  // namespace weft
