#include "weft/kernels/integrate/history.hpp"

#include "cuda/exec/launch.cuh"

namespace weft {

struct RespondHistoryBody {
  template <class T>
  WEFT_HD void operator()(const RespondHistory<T>& a, Index i) const noexcept {
    respond_history(a, i);
  }
};

template <class T>
void run(OnCuda, Queue& queue, const RespondHistory<T>& args) {
  launch_for_each(queue, args, static_cast<Index>(args.velocities.size()), RespondHistoryBody{});
}

template void run(OnCuda, Queue&, const RespondHistory<float>&);
template void run(OnCuda, Queue&, const RespondHistory<double>&);

}  // namespace weft
