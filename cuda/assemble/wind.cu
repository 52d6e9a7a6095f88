#include "weft/kernels/assemble/wind.hpp"

#include "cuda/exec/launch.cuh"

namespace weft {

struct AssembleWindBody {
  template <class T>
  WEFT_HD void operator()(const AssembleWind<T>& a, Index i) const noexcept {
    assemble_wind(a, i);
  }
};

template <class T>
void run(OnCuda, Queue& queue, const AssembleWind<T>& args) {
  launch_for_each(queue, args, static_cast<Index>(args.triangles.size()), AssembleWindBody{});
}

template void run(OnCuda, Queue&, const AssembleWind<float>&);
template void run(OnCuda, Queue&, const AssembleWind<double>&);

}  // namespace weft
