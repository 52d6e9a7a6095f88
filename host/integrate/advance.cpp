#include "weft/kernels/integrate/advance.hpp"

#include "host/exec/for_each.hpp"

namespace weft {

template <class T>
void run(OnHost, Queue& queue, const RespondAdvance<T>& args) {
  submit_for_each(queue, args, static_cast<Index>(args.velocities.size()),
                  [](const RespondAdvance<T>& a, Index i) { respond_advance(a, i); });
}

template void run(OnHost, Queue&, const RespondAdvance<float>&);
template void run(OnHost, Queue&, const RespondAdvance<double>&);

}  // namespace weft
