#include "weft/kernels/integrate/rate.hpp"

#include "cuda/exec/launch.cuh"

namespace weft {

struct RespondRateBody {
  template <class T>
  WEFT_HD void operator()(const RespondRate<T>& a, Index i) const noexcept {
    respond_rate(a, i);
  }
};

template <class T>
void run(OnCuda, Queue& queue, const RespondRate<T>& args) {
  launch_for_each(queue, args, static_cast<Index>(args.velocities.size()), RespondRateBody{});
}

template void run(OnCuda, Queue&, const RespondRate<float>&);
template void run(OnCuda, Queue&, const RespondRate<double>&);

}  // namespace weft
