#include "weft/kernels/element_wise.hpp"

#include "cuda/exec/launch.cuh"

namespace weft {
namespace {

struct OwnBody {
  template <class Args>
  WEFT_HD void operator()(const Args& args, Index i) const noexcept {
    args(i);
  }
};

}  // namespace

template <ElementWise Args>
void run(OnCuda, Queue& queue, const Args& args) {
  launch_for_each(queue, args, args.count(), OwnBody{});
}

#define WEFT_INSTANTIATE(Kernel)                           \
  template void run(OnCuda, Queue&, const Kernel<float>&); \
  template void run(OnCuda, Queue&, const Kernel<double>&);
WEFT_ELEMENT_WISE_KERNELS(WEFT_INSTANTIATE)
template void run(OnCuda, Queue&, const RespondRemember&);

}  // namespace weft
