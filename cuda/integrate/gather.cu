#include "weft/kernels/integrate/gather.hpp"

#include "cuda/exec/launch.cuh"

namespace weft {

struct IntegrateGatherBody {
  template <class T>
  WEFT_HD void operator()(const IntegrateGather<T>& a, Index i) const noexcept {
    integrate_gather(a, i);
  }
};

template <class T>
void run(OnCuda, Queue& queue, const IntegrateGather<T>& args) {
  launch_for_each(queue, args, static_cast<Index>(args.vertices.size()), IntegrateGatherBody{});
}

template void run(OnCuda, Queue&, const IntegrateGather<float>&);
template void run(OnCuda, Queue&, const IntegrateGather<double>&);

}  // namespace weft
