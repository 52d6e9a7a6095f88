#include "weft/kernels/solve/precondition.hpp"

#include "host/exec/for_each.hpp"

namespace weft {

template <class T>
void run(OnHost, Queue& queue, const Precondition<T>& args) {
  submit_for_each(queue, args, args.row_count,
                  [](const Precondition<T>& a, Index i) { precondition(a, i); });
}

template void run(OnHost, Queue&, const Precondition<float>&);
template void run(OnHost, Queue&, const Precondition<double>&);

}  // namespace weft
