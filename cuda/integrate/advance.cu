#include "weft/kernels/integrate/advance.hpp"

#include "cuda/exec/launch.cuh"

namespace weft {

struct IntegrateAdvanceBody {
  template <class T>
  WEFT_HD void operator()(const IntegrateAdvance<T>& a, Index i) const noexcept {
    integrate_advance(a, i);
  }
};

template <class T>
void run(OnCuda, Queue& queue, const IntegrateAdvance<T>& args) {
  launch_for_each(queue, args, static_cast<Index>(args.velocities.size()), IntegrateAdvanceBody{});
}

template void run(OnCuda, Queue&, const IntegrateAdvance<float>&);
template void run(OnCuda, Queue&, const IntegrateAdvance<double>&);

}  // namespace weft
