#include "weft/kernels/solve/initial_guess.hpp"

#include "cuda/exec/launch.cuh"

namespace weft {

struct SolveInitialGuessBody {
  template <class T>
  WEFT_HD void operator()(const SolveInitialGuess<T>& a, Index i) const noexcept {
    solve_initial_guess(a, i);
  }
};

template <class T>
void run(OnCuda, Queue& queue, const SolveInitialGuess<T>& args) {
  launch_for_each(queue, args, args.row_count, SolveInitialGuessBody{});
}

template void run(OnCuda, Queue&, const SolveInitialGuess<float>&);
template void run(OnCuda, Queue&, const SolveInitialGuess<double>&);

}  // namespace weft
