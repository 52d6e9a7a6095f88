#include "weft/kernels/assemble/external_work.hpp"

#include <algorithm>

#include "host/exec/host_device.hpp"

namespace weft {
namespace {

template <class T>
void add_up(const AssembleExternalWork<T>& a) {
  double* out = a.partial.data();
  for (Index first = 0; first < a.items(); first += a.partial_items, ++out) {
    *out = 0;
    for (Index i = first; i < std::min(a.items(), first + a.partial_items); ++i)
      *out += assemble_external_work(a, i);
  }
}

}  // namespace

template <class T>
void run(OnHost, Queue& queue, const AssembleExternalWork<T>& args) {
  submit_host(queue, [args] { add_up(args); });
}

template void run(OnHost, Queue&, const AssembleExternalWork<float>&);
template void run(OnHost, Queue&, const AssembleExternalWork<double>&);

}  // namespace weft
