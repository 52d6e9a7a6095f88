#include "host/implicit/linear/preconditioner_buffers.hpp"

#include "weft/kernels/solve/precondition.hpp"

namespace weft {

template <class T>
void PreconditionerBuffers<T>::make(Device& device, const RankRows& own, Preconditioner chosen,
                                    Index partial_rows) {
  const MemoryName name("preconditioner");
  const auto rows = static_cast<std::size_t>(own.count);
  weft::make(device, inverse_, rows);
  for (int n = 0; n < schwarz_level_count; ++n) {
    SchwarzLevel<T>& level = levels_[n];
    level = {};
    if (chosen != Preconditioner::multilevel || schwarz_aggregates(n, partial_rows) < 2) continue;
    level.shift = schwarz_shift(n);
    level.aggregates = schwarz_aggregates(n, partial_rows);
    const auto domain = static_cast<std::size_t>(level.domain_rows());
    weft::make(
        device, level_inverse_[n],
        (rows + domain - 1) / domain * static_cast<std::size_t>(level.size() * level.size()));
    level.inverse = level_inverse_[n].span();
  }
}

template <class T>
void PreconditionerBuffers<T>::launch_blocks(Queue& queue, const RankRows& own, const Of& of) {
  launch(queue, Precondition<T>{own.begin, own.count, of.mesh.diagonal, of.contact, of.fixed,
                                inverse_.span()});
}

template <class T>
void PreconditionerBuffers<T>::launch_levels(Queue& queue, const RankRows& own, const Of& of) {
  for (const SchwarzLevel<T>& level : levels_)
    if (level.aggregates > 0)
      launch(queue, SolveSchwarzLevel<T>{own.begin, of.mesh, of.far, of.contact, of.fixed, level});
}

template class PreconditionerBuffers<float>;
template class PreconditionerBuffers<double>;

}  // namespace weft
