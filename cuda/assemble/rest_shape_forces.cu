#include "weft/kernels/assemble/rest_shape_forces.hpp"

#include "cuda/exec/launch.cuh"

namespace weft {

struct AssembleShapeTurnsBody {
  template <class T>
  WEFT_HD void operator()(const AssembleShapeTurns<T>& a, Index i) const noexcept {
    assemble_shape_turns(a, i);
  }
};

template <class T>
void run(OnCuda, Queue& queue, const AssembleShapeTurns<T>& args) {
  launch_for_each(queue, args, static_cast<Index>(args.corners.size()), AssembleShapeTurnsBody{});
}

template void run(OnCuda, Queue&, const AssembleShapeTurns<float>&);
template void run(OnCuda, Queue&, const AssembleShapeTurns<double>&);

}  // namespace weft
