#include "weft/kernels/assemble/plate.hpp"

#include "cuda/exec/launch.cuh"

namespace weft {

struct AssemblePlateBody {
  template <class T>
  WEFT_HD void operator()(const AssemblePlate<T>& a, Index i) const noexcept {
    assemble_plate(a, i);
  }
};

template <class T>
void run(OnCuda, Queue& queue, const AssemblePlate<T>& args) {
  launch_for_each(queue, args, args.row_count, AssemblePlateBody{});
}

template void run(OnCuda, Queue&, const AssemblePlate<float>&);
template void run(OnCuda, Queue&, const AssemblePlate<double>&);

}  // namespace weft
