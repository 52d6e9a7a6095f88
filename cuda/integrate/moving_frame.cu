#include "weft/kernels/integrate/moving_frame.hpp"

#include "cuda/exec/launch.cuh"

namespace weft {

struct IntegrateMovingFrameBody {
  template <class T>
  WEFT_HD void operator()(const IntegrateMovingFrame<T>& a, Index i) const noexcept {
    integrate_moving_frame(a, i);
  }
};

template <class T>
void run(OnCuda, Queue& queue, const IntegrateMovingFrame<T>& args) {
  launch_for_each(queue, args, static_cast<Index>(args.component_of_vertex.size()),
                  IntegrateMovingFrameBody{});
}

template void run(OnCuda, Queue&, const IntegrateMovingFrame<float>&);
template void run(OnCuda, Queue&, const IntegrateMovingFrame<double>&);

}  // namespace weft
