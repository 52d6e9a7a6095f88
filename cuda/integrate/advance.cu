#include "weft/kernels/integrate/advance.hpp"

#include "cuda/exec/launch.cuh"

namespace weft {

struct RespondAdvanceBody {
  template <class T>
  WEFT_HD void operator()(const RespondAdvance<T>& a, Index i) const noexcept {
    respond_advance(a, i);
  }
};

template <class T>
void run(OnCuda, Queue& queue, const RespondAdvance<T>& args) {
  launch_for_each(queue, args, static_cast<Index>(args.velocities.size()), RespondAdvanceBody{});
}

template void run(OnCuda, Queue&, const RespondAdvance<float>&);
template void run(OnCuda, Queue&, const RespondAdvance<double>&);

}  // namespace weft
