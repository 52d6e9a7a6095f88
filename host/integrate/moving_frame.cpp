#include "weft/kernels/integrate/moving_frame.hpp"

#include "host/exec/for_each.hpp"

namespace weft {

template <class T>
void run(OnHost, Queue& queue, const RespondDrift<T>& args) {
  submit_for_each(queue, args, static_cast<Index>(args.piece_of_vertex.size()),
                  [](const RespondDrift<T>& a, Index i) { respond_drift(a, i); });
}

template void run(OnHost, Queue&, const RespondDrift<float>&);
template void run(OnHost, Queue&, const RespondDrift<double>&);

}  // namespace weft
