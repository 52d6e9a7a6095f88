#include "host/implicit/linear/preconditioners/coarse_basis_buffers.hpp"

#include "host/state/store.hpp"
#include "weft/kernels/solve/coarse_inverse.hpp"

namespace weft {
namespace {

template <class T>
std::vector<CoarseBasisStep<T>> cast_steps(const std::vector<CoarseBasisStep<double>>& steps) {
  std::vector<CoarseBasisStep<T>> result;
  result.reserve(steps.size());
  for (const CoarseBasisStep<double>& s : steps)
    result.push_back({static_cast<T>(s.u), static_cast<T>(s.v), static_cast<T>(s.scale)});
  return result;
}

}  // namespace

template <class T>
void CoarseBasisBuffers<T>::make(Device& device, const CoarseBasisTable& table, Index row_begin,
                                 Index row_count) {
  const auto put = [&](auto& buffer, const auto& values) {
    buffer = std::remove_reference_t<decltype(buffer)>(device);
    upload(device.compute(), buffer, values);
    return buffer.span();
  };
  const auto room = [&](auto& buffer, std::size_t size) {
    buffer = std::remove_reference_t<decltype(buffer)>(device, size);
    return buffer.span();
  };
  CoarseBasisLevels<T>& l = levels_;
  l.partial_rows = table.partial_rows;
  l.unit_rows = table.unit_rows;
  l.point = put(point_, table.point);
  l.unit = put(unit_, cast_steps<T>(table.unit));
  l.upper_count = static_cast<int>(table.aggregates.size());
  constexpr std::size_t matrix = coarse_domain_dofs * coarse_domain_dofs;
  constexpr std::size_t block = coarse_dofs * coarse_dofs;
  for (int k = 0; k < l.upper_count; ++k) {
    const auto n = static_cast<std::size_t>(k);
    CoarseBasisLevel<T>& level = l.upper[k];
    level.aggregates = table.aggregates[n];
    if (k + 1 < l.upper_count) level.larger = put(larger_[k], cast_steps<T>(table.larger[n]));
    level.inverse = room(inverse_[k], matrix * static_cast<std::size_t>(level.domains()));
    if (k > 0) room(diagonal_[k], block * static_cast<std::size_t>(level.aggregates));
  }
  const auto partials = static_cast<std::size_t>(table.aggregates.front());
  const auto own = static_cast<std::size_t>((row_count + l.partial_rows - 1) / l.partial_rows);
  const auto fine = static_cast<std::size_t>(l.fine_size());
  if (l.has_fine()) l.fine_inverse = room(fine_inverse_, own * fine * fine);
  l.sum = room(sum_, 2 * partials * coarse_dofs);
  l.move = room(move_, 3 * own * coarse_dofs);
  const std::size_t strip =
      static_cast<std::size_t>(l.upper_count) * coarse_dofs * coarse_domain_dofs;
  room(strip_, partials * strip);
  own_strips_ = {static_cast<std::size_t>(row_begin / l.partial_rows) * strip, own * strip};
  if (own == 0) own_strips_ = {};
}

template <class T>
void CoarseBasisBuffers<T>::launch_coarse_inverse(Queue& queue) {
  for (int k = 0; k < levels_.upper_count; ++k) {
    const bool last = k + 1 == levels_.upper_count;
    launch(queue, SolveCoarseInverse<T>{levels_, k, strip_.span(), diagonal_[k].span(),
                                        last ? Span<double>{} : diagonal_[k + 1].span()});
  }
}

template class CoarseBasisBuffers<float>;
template class CoarseBasisBuffers<double>;

}  // namespace weft
