#include "weft/kernels/assemble/plate.hpp"

#include "host/exec/for_each.hpp"

namespace weft {

template <class T>
void run(OnHost, Queue& queue, const AssemblePlate<T>& args) {
  submit_for_each(queue, args, args.row_count,
                  [](const AssemblePlate<T>& a, Index i) { assemble_plate(a, i); });
}

template void run(OnHost, Queue&, const AssemblePlate<float>&);
template void run(OnHost, Queue&, const AssemblePlate<double>&);

}  // namespace weft
