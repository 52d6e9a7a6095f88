#include "weft/kernels/solve/held_components.hpp"

#include "host/exec/for_each.hpp"

namespace weft {

template <class T>
void run(OnHost, Queue& queue, const SolveHeldComponents<T>& args) {
  submit_for_each(queue, args, static_cast<Index>(args.contacts.size()),
                  [](const SolveHeldComponents<T>& a, Index i) { solve_held_components(a, i); });
}

template void run(OnHost, Queue&, const SolveHeldComponents<float>&);
template void run(OnHost, Queue&, const SolveHeldComponents<double>&);

}  // namespace weft
