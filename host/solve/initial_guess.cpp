#include "weft/kernels/solve/initial_guess.hpp"

#include "host/exec/for_each.hpp"

namespace weft {

template <class T>
void run(OnHost, Queue& queue, const SolveInitialGuess<T>& args) {
  submit_for_each(queue, args, args.row_count,
                  [](const SolveInitialGuess<T>& a, Index i) { solve_initial_guess(a, i); });
}

template void run(OnHost, Queue&, const SolveInitialGuess<float>&);
template void run(OnHost, Queue&, const SolveInitialGuess<double>&);

}  // namespace weft
