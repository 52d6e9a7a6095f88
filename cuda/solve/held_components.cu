#include "weft/kernels/solve/held_components.hpp"

#include "cuda/exec/launch.cuh"

namespace weft {

struct SolveHeldComponentsBody {
  template <class T>
  WEFT_HD void operator()(const SolveHeldComponents<T>& a, Index i) const noexcept {
    solve_held_components(a, i);
  }
};

template <class T>
void run(OnCuda, Queue& queue, const SolveHeldComponents<T>& args) {
  launch_for_each(queue, args, static_cast<Index>(args.contacts.size()), SolveHeldComponentsBody{});
}

template void run(OnCuda, Queue&, const SolveHeldComponents<float>&);
template void run(OnCuda, Queue&, const SolveHeldComponents<double>&);

}  // namespace weft
