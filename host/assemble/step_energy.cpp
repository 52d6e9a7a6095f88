#include "weft/kernels/assemble/step_energy.hpp"

#include <algorithm>

#include "host/exec/host_device.hpp"

namespace weft {
namespace {

template <class T>
void add_up(const AssembleStepEnergy<T>& a) {
  double* out = a.partial.data();
  for (Index first = 0; first < a.row_count; first += a.partial_rows, out += 3) {
    std::fill_n(out, 3, 0.0);
    for (Index i = first; i < std::min(a.row_count, first + a.partial_rows); ++i)
      add_step_energy(a, i, out);
  }
}

}  // namespace

template <class T>
void run(OnHost, Queue& queue, const AssembleStepEnergy<T>& args) {
  submit_host(queue, [args] { add_up(args); });
}

template void run(OnHost, Queue&, const AssembleStepEnergy<float>&);
template void run(OnHost, Queue&, const AssembleStepEnergy<double>&);

}  // namespace weft
