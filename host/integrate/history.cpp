#include "weft/kernels/integrate/history.hpp"

#include "host/exec/for_each.hpp"

namespace weft {

template <class T>
void run(OnHost, Queue& queue, const IntegrateHistory<T>& args) {
  submit_for_each(queue, args, static_cast<Index>(args.velocities.size()),
                  [](const IntegrateHistory<T>& a, Index i) { integrate_history(a, i); });
}

template void run(OnHost, Queue&, const IntegrateHistory<float>&);
template void run(OnHost, Queue&, const IntegrateHistory<double>&);

}  // namespace weft
