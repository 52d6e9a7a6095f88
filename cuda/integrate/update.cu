#include "weft/kernels/integrate/update.hpp"

#include "cuda/exec/launch.cuh"

namespace weft {

struct IntegrateUpdateBody {
  template <class T>
  WEFT_HD void operator()(const IntegrateUpdate<T>& a, Index i) const noexcept {
    integrate_update(a, i);
  }
};

template <class T>
void run(OnCuda, Queue& queue, const IntegrateUpdate<T>& args) {
  launch_for_each(queue, args, args.row_count, IntegrateUpdateBody{});
}

template void run(OnCuda, Queue&, const IntegrateUpdate<float>&);
template void run(OnCuda, Queue&, const IntegrateUpdate<double>&);

}  // namespace weft
