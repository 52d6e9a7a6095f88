#include "weft/kernels/integrate/advance.hpp"

#include "host/exec/for_each.hpp"

namespace weft {

template <class T>
void run(OnHost, Queue& queue, const IntegrateAdvance<T>& args) {
  submit_for_each(queue, args, static_cast<Index>(args.velocities.size()),
                  [](const IntegrateAdvance<T>& a, Index i) { integrate_advance(a, i); });
}

template void run(OnHost, Queue&, const IntegrateAdvance<float>&);
template void run(OnHost, Queue&, const IntegrateAdvance<double>&);

}  // namespace weft
