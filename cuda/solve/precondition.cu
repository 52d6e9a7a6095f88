#include "weft/kernels/solve/precondition.hpp"

#include "cuda/exec/launch.cuh"

namespace weft {

struct PreconditionBody {
  template <class T>
  WEFT_HD void operator()(const Precondition<T>& a, Index i) const noexcept {
    precondition(a, i);
  }
};

template <class T>
void run(OnCuda, Queue& queue, const Precondition<T>& args) {
  launch_for_each(queue, args, args.row_count, PreconditionBody{});
}

template void run(OnCuda, Queue&, const Precondition<float>&);
template void run(OnCuda, Queue&, const Precondition<double>&);

}  // namespace weft
