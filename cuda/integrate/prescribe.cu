#include "weft/kernels/integrate/prescribe.hpp"

#include "cuda/exec/launch.cuh"

namespace weft {

struct RespondPrescribeBody {
  template <class T>
  WEFT_HD void operator()(const RespondPrescribe<T>& a, Index i) const noexcept {
    respond_prescribe(a, i);
  }
};

template <class T>
void run(OnCuda, Queue& queue, const RespondPrescribe<T>& args) {
  launch_for_each(queue, args, static_cast<Index>(args.targets.size()), RespondPrescribeBody{});
}

template void run(OnCuda, Queue&, const RespondPrescribe<float>&);
template void run(OnCuda, Queue&, const RespondPrescribe<double>&);

}  // namespace weft
