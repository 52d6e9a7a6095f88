#include "weft/kernels/respond/apply.hpp"

#include "cuda/exec/launch.cuh"

namespace weft {

struct RespondApplyBody {
  template <class T>
  WEFT_HD void operator()(const RespondApply<T>& a, Index i) const noexcept {
    respond_apply(a, i);
  }
};

template <class T>
void run(OnCuda, Queue& queue, const RespondApply<T>& args) {
  launch_for_each(queue, args, static_cast<Index>(args.moved.size()), RespondApplyBody{});
}

template void run(OnCuda, Queue&, const RespondApply<float>&);
template void run(OnCuda, Queue&, const RespondApply<double>&);

}  // namespace weft
