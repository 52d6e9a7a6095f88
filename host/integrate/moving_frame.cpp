#include "weft/kernels/integrate/moving_frame.hpp"

#include "host/exec/for_each.hpp"

namespace weft {

template <class T>
void run(OnHost, Queue& queue, const IntegrateMovingFrame<T>& args) {
  submit_for_each(queue, args, static_cast<Index>(args.component_of_vertex.size()),
                  [](const IntegrateMovingFrame<T>& a, Index i) { integrate_moving_frame(a, i); });
}

template void run(OnHost, Queue&, const IntegrateMovingFrame<float>&);
template void run(OnHost, Queue&, const IntegrateMovingFrame<double>&);

}  // namespace weft
