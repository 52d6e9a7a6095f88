#include "weft/kernels/integrate/history.hpp"

#include "cuda/exec/launch.cuh"

namespace weft {

struct IntegrateHistoryBody {
  template <class T>
  WEFT_HD void operator()(const IntegrateHistory<T>& a, Index i) const noexcept {
    integrate_history(a, i);
  }
};

template <class T>
void run(OnCuda, Queue& queue, const IntegrateHistory<T>& args) {
  launch_for_each(queue, args, static_cast<Index>(args.velocities.size()), IntegrateHistoryBody{});
}

template void run(OnCuda, Queue&, const IntegrateHistory<float>&);
template void run(OnCuda, Queue&, const IntegrateHistory<double>&);

}  // namespace weft
