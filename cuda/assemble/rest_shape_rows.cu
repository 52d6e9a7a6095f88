#include "weft/kernels/assemble/rest_shape_rows.hpp"

#include "cuda/exec/launch.cuh"

namespace weft {

struct AssembleRestShapeRowsBody {
  template <class T>
  WEFT_HD void operator()(const AssembleRestShapeRows<T>& a, Index i) const noexcept {
    assemble_rest_shape_rows(a, i);
  }
};

template <class T>
void run(OnCuda, Queue& queue, const AssembleRestShapeRows<T>& args) {
  launch_for_each(queue, args, args.row_count, AssembleRestShapeRowsBody{});
}

template void run(OnCuda, Queue&, const AssembleRestShapeRows<float>&);
template void run(OnCuda, Queue&, const AssembleRestShapeRows<double>&);

}  // namespace weft
