#include "weft/kernels/assemble/pressure.hpp"

#include "cuda/exec/launch.cuh"

namespace weft {

struct AssemblePressureBody {
  template <class T>
  WEFT_HD void operator()(const AssemblePressure<T>& a, Index i) const noexcept {
    assemble_pressure(a, i);
  }
};

template <class T>
void run(OnCuda, Queue& queue, const AssemblePressure<T>& args) {
  launch_for_each(queue, args, static_cast<Index>(args.triangles.size()), AssemblePressureBody{});
}

template void run(OnCuda, Queue&, const AssemblePressure<float>&);
template void run(OnCuda, Queue&, const AssemblePressure<double>&);

}  // namespace weft
