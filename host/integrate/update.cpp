#include "weft/kernels/integrate/update.hpp"

#include "host/exec/for_each.hpp"

namespace weft {

template <class T>
void run(OnHost, Queue& queue, const IntegrateUpdate<T>& args) {
  submit_for_each(queue, args, args.row_count,
                  [](const IntegrateUpdate<T>& a, Index i) { integrate_update(a, i); });
}

template void run(OnHost, Queue&, const IntegrateUpdate<float>&);
template void run(OnHost, Queue&, const IntegrateUpdate<double>&);

}  // namespace weft
