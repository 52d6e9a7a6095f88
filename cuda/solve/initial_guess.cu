#include "weft/kernels/solve/initial_guess.hpp"

#include "cuda/exec/launch.cuh"

namespace weft {

struct SolveGuessBody {
  template <class T>
  WEFT_HD void operator()(const SolveGuess<T>& a, Index i) const noexcept {
    solve_guess(a, i);
  }
};

template <class T>
void run(OnCuda, Queue& queue, const SolveGuess<T>& args) {
  launch_for_each(queue, args, args.row_count, SolveGuessBody{});
}

template void run(OnCuda, Queue&, const SolveGuess<float>&);
template void run(OnCuda, Queue&, const SolveGuess<double>&);

}  // namespace weft
