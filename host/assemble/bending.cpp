#include "weft/kernels/assemble/bending.hpp"

#include "host/exec/for_each.hpp"

namespace weft {

template <class T>
void run(OnHost, Queue& queue, const AssembleBending<T>& args) {
  submit_for_each(queue, args, static_cast<Index>(args.hinges.size()),
                  [](const AssembleBending<T>& a, Index i) { assemble_bending(a, i); });
}

template void run(OnHost, Queue&, const AssembleBending<float>&);
template void run(OnHost, Queue&, const AssembleBending<double>&);

}  // namespace weft
