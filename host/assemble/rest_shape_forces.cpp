#include "weft/kernels/assemble/rest_shape_forces.hpp"

#include "host/exec/for_each.hpp"

namespace weft {

template <class T>
void run(OnHost, Queue& queue, const AssembleRestShapeForces<T>& args) {
  submit_for_each(
      queue, args, static_cast<Index>(args.corners.size()),
      [](const AssembleRestShapeForces<T>& a, Index i) { assemble_rest_shape_forces(a, i); });
}

template void run(OnHost, Queue&, const AssembleRestShapeForces<float>&);
template void run(OnHost, Queue&, const AssembleRestShapeForces<double>&);

}  // namespace weft
