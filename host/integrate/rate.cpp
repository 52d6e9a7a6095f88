#include "weft/kernels/integrate/rate.hpp"

#include "host/exec/for_each.hpp"

namespace weft {

template <class T>
void run(OnHost, Queue& queue, const IntegrateRate<T>& args) {
  submit_for_each(queue, args, static_cast<Index>(args.velocities.size()),
                  [](const IntegrateRate<T>& a, Index i) { integrate_rate(a, i); });
}

template void run(OnHost, Queue&, const IntegrateRate<float>&);
template void run(OnHost, Queue&, const IntegrateRate<double>&);

}  // namespace weft
