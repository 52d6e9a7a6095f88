#include "weft/kernels/respond/apply.hpp"

#include "host/exec/for_each.hpp"

namespace weft {

template <class T>
void run(OnHost, Queue& queue, const RespondApply<T>& args) {
  submit_for_each(queue, args, static_cast<Index>(args.moved.size()),
                  [](const RespondApply<T>& a, Index i) { respond_apply(a, i); });
}

template void run(OnHost, Queue&, const RespondApply<float>&);
template void run(OnHost, Queue&, const RespondApply<double>&);

}  // namespace weft
