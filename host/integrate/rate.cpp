#include "weft/kernels/integrate/rate.hpp"

#include "host/exec/for_each.hpp"

namespace weft {

template <class T>
void run(OnHost, Queue& queue, const RespondRate<T>& args) {
  submit_for_each(queue, args, static_cast<Index>(args.velocities.size()),
                  [](const RespondRate<T>& a, Index i) { respond_rate(a, i); });
}

template void run(OnHost, Queue&, const RespondRate<float>&);
template void run(OnHost, Queue&, const RespondRate<double>&);

}  // namespace weft
