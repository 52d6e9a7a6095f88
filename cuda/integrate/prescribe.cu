#include "weft/kernels/integrate/prescribe.hpp"

#include "cuda/exec/launch.cuh"

namespace weft {

struct IntegratePrescribeBody {
  template <class T>
  WEFT_HD void operator()(const IntegratePrescribe<T>& a, Index i) const noexcept {
    integrate_prescribe(a, i);
  }
};

template <class T>
void run(OnCuda, Queue& queue, const IntegratePrescribe<T>& args) {
  launch_for_each(queue, args, static_cast<Index>(args.targets.size()), IntegratePrescribeBody{});
}

template void run(OnCuda, Queue&, const IntegratePrescribe<float>&);
template void run(OnCuda, Queue&, const IntegratePrescribe<double>&);

}  // namespace weft
