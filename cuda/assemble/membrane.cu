#include "weft/kernels/assemble/membrane.hpp"

#include "cuda/exec/launch.cuh"

namespace weft {

struct AssembleMembraneBody {
  template <class T>
  WEFT_HD void operator()(const AssembleMembrane<T>& a, Index i) const noexcept {
    assemble_membrane(a, i);
  }
};

template <class T>
void run(OnCuda, Queue& queue, const AssembleMembrane<T>& args) {
  launch_for_each(queue, args, static_cast<Index>(args.triangles.size()), AssembleMembraneBody{});
}

template void run(OnCuda, Queue&, const AssembleMembrane<float>&);
template void run(OnCuda, Queue&, const AssembleMembrane<double>&);

}  // namespace weft
