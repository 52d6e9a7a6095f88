#include "weft/kernels/assemble/membrane.hpp"

#include "host/exec/for_each.hpp"

namespace weft {

template <class T>
void run(OnHost, Queue& queue, const AssembleMembrane<T>& args) {
  submit_for_each(queue, args, static_cast<Index>(args.triangles.size()),
                  [](const AssembleMembrane<T>& a, Index i) { assemble_membrane(a, i); });
}

template void run(OnHost, Queue&, const AssembleMembrane<float>&);
template void run(OnHost, Queue&, const AssembleMembrane<double>&);

}  // namespace weft
