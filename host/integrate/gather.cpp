#include "weft/kernels/integrate/gather.hpp"

#include "host/exec/for_each.hpp"

namespace weft {

template <class T>
void run(OnHost, Queue& queue, const IntegrateGather<T>& args) {
  submit_for_each(queue, args, static_cast<Index>(args.vertices.size()),
                  [](const IntegrateGather<T>& a, Index i) { integrate_gather(a, i); });
}

template void run(OnHost, Queue&, const IntegrateGather<float>&);
template void run(OnHost, Queue&, const IntegrateGather<double>&);

}  // namespace weft
