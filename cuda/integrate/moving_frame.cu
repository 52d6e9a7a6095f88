#include "weft/kernels/integrate/moving_frame.hpp"

#include "cuda/exec/launch.cuh"

namespace weft {

struct RespondDriftBody {
  template <class T>
  WEFT_HD void operator()(const RespondDrift<T>& a, Index i) const noexcept {
    respond_drift(a, i);
  }
};

template <class T>
void run(OnCuda, Queue& queue, const RespondDrift<T>& args) {
  launch_for_each(queue, args, static_cast<Index>(args.piece_of_vertex.size()), RespondDriftBody{});
}

template void run(OnCuda, Queue&, const RespondDrift<float>&);
template void run(OnCuda, Queue&, const RespondDrift<double>&);

}  // namespace weft
