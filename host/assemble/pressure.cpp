#include "weft/kernels/assemble/pressure.hpp"

#include "host/exec/for_each.hpp"

namespace weft {

template <class T>
void run(OnHost, Queue& queue, const AssemblePressure<T>& args) {
  submit_for_each(queue, args, static_cast<Index>(args.triangles.size()),
                  [](const AssemblePressure<T>& a, Index i) { assemble_pressure(a, i); });
}

template void run(OnHost, Queue&, const AssemblePressure<float>&);
template void run(OnHost, Queue&, const AssemblePressure<double>&);

}  // namespace weft
