#include "host/implicit/step_error.hpp"

#include <algorithm>
#include <cmath>

#include "weft/kernels/integrate/step_error.hpp"

namespace weft {

template <class T>
StepError<T>::StepError(Store<T>& store) : store_(store), rank_sums_(store.devices()[0]) {}

template <class T>
double StepError<T>::measure(const RankGeometry<T>& geometry) {
  const RankState<T>& state = store_.rank(0);
  Queue& queue = store_.devices()[0].compute();
  rank_sums_.resize(2 * geometry.component_inverse_mass.size());
  queue.fill(rank_sums_.data(), 0, rank_sums_.size() * sizeof(std::int64_t));
  launch(queue,
         IntegrateStepError<T>{
             state.previous_positions.span(), state.previous_velocities.span(),
             state.positions.span(), state.velocities.span(), geometry.fixed.span(),
             geometry.component_of_vertex.span(), store_.previous_step,
             1 / (store_.scene().time.tolerance * store_.model().mean_edge), rank_sums_.span()});
  const std::vector<std::int64_t> sums = download(queue, rank_sums_);
  double worst = 0;
  for (std::size_t c = 0; c < sums.size(); c += 2)
    if (sums[c + 1] > 0)
      worst = std::max(worst, static_cast<double>(sums[c]) / static_cast<double>(sums[c + 1]));
  return std::sqrt(worst / step_error_one);
}

template class StepError<float>;
template class StepError<double>;

}  // namespace weft
