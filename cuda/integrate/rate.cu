#include "weft/kernels/integrate/rate.hpp"

#include "cuda/exec/launch.cuh"

namespace weft {

struct IntegrateRateBody {
  template <class T>
  WEFT_HD void operator()(const IntegrateRate<T>& a, Index i) const noexcept {
    integrate_rate(a, i);
  }
};

template <class T>
void run(OnCuda, Queue& queue, const IntegrateRate<T>& args) {
  launch_for_each(queue, args, static_cast<Index>(args.velocities.size()), IntegrateRateBody{});
}

template void run(OnCuda, Queue&, const IntegrateRate<float>&);
template void run(OnCuda, Queue&, const IntegrateRate<double>&);

}  // namespace weft
