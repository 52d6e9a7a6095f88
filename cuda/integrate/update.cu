#include "weft/kernels/integrate/update.hpp"

#include "cuda/exec/launch.cuh"

namespace weft {

struct RespondUpdateBody {
  template <class T>
  WEFT_HD void operator()(const RespondUpdate<T>& a, Index i) const noexcept {
    respond_update(a, i);
  }
};

template <class T>
void run(OnCuda, Queue& queue, const RespondUpdate<T>& args) {
  launch_for_each(queue, args, args.row_count, RespondUpdateBody{});
}

template void run(OnCuda, Queue&, const RespondUpdate<float>&);
template void run(OnCuda, Queue&, const RespondUpdate<double>&);

}  // namespace weft
