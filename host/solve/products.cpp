#include "weft/kernels/solve/products.hpp"

#include <algorithm>

#include "host/exec/host_device.hpp"

namespace weft {
namespace {

template <class T>
void multiply(const SolveProducts<T>& a) {
  double* out = a.partial.data();
  for (Index first = 0; first < a.row_count; first += a.partial_rows, out += 2) {
    out[0] = out[1] = 0;
    for (Index i = first; i < std::min(a.row_count, first + a.partial_rows); ++i) {
      if (a.fixed.data()[a.row_begin + i] != 0) continue;
      const Vec3<double> r = vec_cast<double>(a.residual.data()[i]);
      out[0] += dot(r, vec_cast<double>(a.direction.data()[a.row_begin + i]));
      out[1] += dot(r, r);
    }
  }
}

}  // namespace

template <class T>
void run(OnHost, Queue& queue, const SolveProducts<T>& args) {
  submit_host(queue, [args] { multiply(args); });
}

template void run(OnHost, Queue&, const SolveProducts<float>&);
template void run(OnHost, Queue&, const SolveProducts<double>&);

}  // namespace weft
