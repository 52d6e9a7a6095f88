#include "weft/kernels/assemble/bending.hpp"

#include "cuda/exec/launch.cuh"

namespace weft {

struct AssembleBendingBody {
  template <class T>
  WEFT_HD void operator()(const AssembleBending<T>& a, Index i) const noexcept {
    assemble_bending(a, i);
  }
};

template <class T>
void run(OnCuda, Queue& queue, const AssembleBending<T>& args) {
  launch_for_each(queue, args, static_cast<Index>(args.hinges.size()), AssembleBendingBody{});
}

template void run(OnCuda, Queue&, const AssembleBending<float>&);
template void run(OnCuda, Queue&, const AssembleBending<double>&);

}  // namespace weft
