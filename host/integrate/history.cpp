#include "weft/kernels/integrate/history.hpp"

#include "host/exec/for_each.hpp"

namespace weft {

template <class T>
void run(OnHost, Queue& queue, const RespondHistory<T>& args) {
  submit_for_each(queue, args, static_cast<Index>(args.velocities.size()),
                  [](const RespondHistory<T>& a, Index i) { respond_history(a, i); });
}

template void run(OnHost, Queue&, const RespondHistory<float>&);
template void run(OnHost, Queue&, const RespondHistory<double>&);

}  // namespace weft
