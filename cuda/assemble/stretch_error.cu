#include "weft/kernels/assemble/stretch_error.hpp"

#include "cuda/exec/launch.cuh"

namespace weft {

struct AssembleStretchErrorBody {
  template <class T>
  WEFT_HD void operator()(const AssembleStretchError<T>& a, Index i) const noexcept {
    assemble_stretch_error(a, i);
  }
};

template <class T>
void run(OnCuda, Queue& queue, const AssembleStretchError<T>& args) {
  launch_for_each(queue, args, static_cast<Index>(args.triangles.size()),
                  AssembleStretchErrorBody{});
}

template void run(OnCuda, Queue&, const AssembleStretchError<float>&);
template void run(OnCuda, Queue&, const AssembleStretchError<double>&);

}  // namespace weft
