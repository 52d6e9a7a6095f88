#include "weft/kernels/assemble/rows.hpp"

#include "cuda/exec/launch.cuh"

namespace weft {

struct AssembleRowsBody {
  template <class T>
  WEFT_HD void operator()(const AssembleRows<T>& a, Index i) const noexcept {
    assemble_row(a, i);
  }
};

template <class T>
void run(OnCuda, Queue& queue, const AssembleRows<T>& args) {
  launch_for_each(queue, args, args.matrix.row_count, AssembleRowsBody{});
}

template void run(OnCuda, Queue&, const AssembleRows<float>&);
template void run(OnCuda, Queue&, const AssembleRows<double>&);

}  // namespace weft
