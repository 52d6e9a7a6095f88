#include <algorithm>

#include "host/implicit/linear/linear_system.hpp"
#include "host/implicit/parallel/exchange.hpp"
#include "weft/kernels/solve/schwarz_level.hpp"

namespace weft {

/// Memory of what the preconditioner has beside block Jacobi.
template <class T>
void LinearSystem<T>::make_preconditioner(int r) {
  Device& device = store_.devices()[r];
  Rank& rank = ranks_[static_cast<std::size_t>(r)];
  const auto own = static_cast<std::size_t>(row_count(r));
  for (int level = 0; level < schwarz_level_count; ++level) {
    const SchwarzLevel<T> c = coarse_level(r, level);
    if (c.aggregates == 0) continue;
    const auto domain = static_cast<std::size_t>(c.domain_rows());
    rank.schwarz_inverse[level] = Buffer<T>(
        device, (own + domain - 1) / domain * static_cast<std::size_t>(c.size() * c.size()));
  }
}

/// Level of the preconditioner that rank r works with; without aggregates if it is not in use.
template <class T>
SchwarzLevel<T> LinearSystem<T>::coarse_level(int r, int level) const {
  if (store_.scene().solver.preconditioner != Preconditioner::multilevel) return {};
  const Index aggregates = schwarz_aggregates(level, store_.partition().partial_rows);
  if (aggregates < 2) return {};
  return {schwarz_shift(level), aggregates,
          ranks_[static_cast<std::size_t>(r)].schwarz_inverse[level].span()};
}

template <class T>
void LinearSystem<T>::launch_coarse(int r) {
  for (int level = 0; level < schwarz_level_count; ++level) {
    const SchwarzLevel<T> c = coarse_level(r, level);
    if (c.aggregates > 0)
      launch(store_.devices()[r].compute(),
             SolveSchwarzLevel<T>{row_begin(r), mesh_view(r), far_view(r), contact_view(r),
                                  geometry_[static_cast<std::size_t>(r)].fixed.span(), c});
  }
}

template void LinearSystem<float>::make_preconditioner(int);
template void LinearSystem<double>::make_preconditioner(int);
template SchwarzLevel<float> LinearSystem<float>::coarse_level(int, int) const;
template SchwarzLevel<double> LinearSystem<double>::coarse_level(int, int) const;
template void LinearSystem<float>::launch_coarse(int);
template void LinearSystem<double>::launch_coarse(int);

}  // namespace weft
