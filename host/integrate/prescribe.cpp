#include "weft/kernels/integrate/prescribe.hpp"

#include "host/exec/for_each.hpp"

namespace weft {

template <class T>
void run(OnHost, Queue& queue, const IntegratePrescribe<T>& args) {
  submit_for_each(queue, args, static_cast<Index>(args.targets.size()),
                  [](const IntegratePrescribe<T>& a, Index i) { integrate_prescribe(a, i); });
}

template void run(OnHost, Queue&, const IntegratePrescribe<float>&);
template void run(OnHost, Queue&, const IntegratePrescribe<double>&);

}  // namespace weft
