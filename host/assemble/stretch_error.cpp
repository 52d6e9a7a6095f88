#include "weft/kernels/assemble/stretch_error.hpp"

#include "host/exec/for_each.hpp"

namespace weft {

template <class T>
void run(OnHost, Queue& queue, const AssembleStretchError<T>& args) {
  submit_for_each(queue, args, static_cast<Index>(args.triangles.size()),
                  [](const AssembleStretchError<T>& a, Index i) { assemble_stretch_error(a, i); });
}

template void run(OnHost, Queue&, const AssembleStretchError<float>&);
template void run(OnHost, Queue&, const AssembleStretchError<double>&);

}  // namespace weft
