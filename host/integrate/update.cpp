#include "weft/kernels/integrate/update.hpp"

#include "host/exec/for_each.hpp"

namespace weft {

template <class T>
void run(OnHost, Queue& queue, const RespondUpdate<T>& args) {
  submit_for_each(queue, args, args.row_count,
                  [](const RespondUpdate<T>& a, Index i) { respond_update(a, i); });
}

template void run(OnHost, Queue&, const RespondUpdate<float>&);
template void run(OnHost, Queue&, const RespondUpdate<double>&);

}  // namespace weft
