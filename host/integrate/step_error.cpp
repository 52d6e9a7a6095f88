#include "weft/kernels/integrate/step_error.hpp"

#include "host/exec/for_each.hpp"

namespace weft {

template <class T>
void run(OnHost, Queue& queue, const IntegrateStepError<T>& args) {
  submit_for_each(queue, args, static_cast<Index>(args.component_of_vertex.size()),
                  [](const IntegrateStepError<T>& a, Index i) {
                    const VertexStepError e = integrate_step_error(a, i);
                    if (e.component < 0) return;
                    for (std::size_t k = 0; k < 2; ++k)
                      a.sums[2 * static_cast<std::size_t>(e.component) + k] += e.sum[k];
                  });
}

template void run(OnHost, Queue&, const IntegrateStepError<float>&);
template void run(OnHost, Queue&, const IntegrateStepError<double>&);

}  // namespace weft
