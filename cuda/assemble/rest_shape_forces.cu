#include "weft/kernels/assemble/rest_shape_forces.hpp"

#include "cuda/exec/launch.cuh"

namespace weft {

struct AssembleRestShapeForcesBody {
  template <class T>
  WEFT_HD void operator()(const AssembleRestShapeForces<T>& a, Index i) const noexcept {
    assemble_rest_shape_forces(a, i);
  }
};

template <class T>
void run(OnCuda, Queue& queue, const AssembleRestShapeForces<T>& args) {
  launch_for_each(queue, args, static_cast<Index>(args.corners.size()),
                  AssembleRestShapeForcesBody{});
}

template void run(OnCuda, Queue&, const AssembleRestShapeForces<float>&);
template void run(OnCuda, Queue&, const AssembleRestShapeForces<double>&);

}  // namespace weft
