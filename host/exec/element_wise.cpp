#include "weft/kernels/element_wise.hpp"

#include "host/exec/for_each.hpp"

namespace weft {

template <ElementWise Args>
void run(OnHost, Queue& queue, const Args& args) {
  submit_for_each(queue, args, args.count(), [](const Args& a, Index i) { a(i); });
}

#define WEFT_INSTANTIATE(Kernel)                           \
  template void run(OnHost, Queue&, const Kernel<float>&); \
  template void run(OnHost, Queue&, const Kernel<double>&);
WEFT_ELEMENT_WISE_KERNELS(WEFT_INSTANTIATE)
template void run(OnHost, Queue&, const RespondRemember&);

}  // namespace weft
