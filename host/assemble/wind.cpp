#include "weft/kernels/assemble/wind.hpp"

#include "host/exec/for_each.hpp"

namespace weft {

template <class T>
void run(OnHost, Queue& queue, const AssembleWind<T>& args) {
  submit_for_each(queue, args, static_cast<Index>(args.triangles.size()),
                  [](const AssembleWind<T>& a, Index i) { assemble_wind(a, i); });
}

template void run(OnHost, Queue&, const AssembleWind<float>&);
template void run(OnHost, Queue&, const AssembleWind<double>&);

}  // namespace weft
