#include "weft/kernels/assemble/rest_shape_forces.hpp"

#include "host/exec/for_each.hpp"

namespace weft {

template <class T>
void run(OnHost, Queue& queue, const AssembleShapeTurns<T>& args) {
  submit_for_each(queue, args, static_cast<Index>(args.corners.size()),
                  [](const AssembleShapeTurns<T>& a, Index i) { assemble_shape_turns(a, i); });
}

template void run(OnHost, Queue&, const AssembleShapeTurns<float>&);
template void run(OnHost, Queue&, const AssembleShapeTurns<double>&);

}  // namespace weft
