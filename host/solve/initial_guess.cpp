#include "weft/kernels/solve/initial_guess.hpp"

#include "host/exec/for_each.hpp"

namespace weft {

template <class T>
void run(OnHost, Queue& queue, const SolveGuess<T>& args) {
  submit_for_each(queue, args, args.row_count,
                  [](const SolveGuess<T>& a, Index i) { solve_guess(a, i); });
}

template void run(OnHost, Queue&, const SolveGuess<float>&);
template void run(OnHost, Queue&, const SolveGuess<double>&);

}  // namespace weft
