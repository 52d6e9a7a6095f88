#include "weft/kernels/integrate/prescribe.hpp"

#include "host/exec/for_each.hpp"

namespace weft {

template <class T>
void run(OnHost, Queue& queue, const RespondPrescribe<T>& args) {
  submit_for_each(queue, args, static_cast<Index>(args.targets.size()),
                  [](const RespondPrescribe<T>& a, Index i) { respond_prescribe(a, i); });
}

template void run(OnHost, Queue&, const RespondPrescribe<float>&);
template void run(OnHost, Queue&, const RespondPrescribe<double>&);

}  // namespace weft
