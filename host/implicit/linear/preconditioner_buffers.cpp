#include "host/implicit/linear/preconditioner_buffers.hpp"

#include "weft/kernels/solve/precondition.hpp"

namespace weft {

template <class T>
void PreconditionerBuffers<T>::make(Device& device, const RankRows& own, Preconditioner chosen,
                                    Index partial_rows) {
  const MemoryName name("preconditioner");
  weft::make(device, inverse_, own.block_numbers());
  fine_ = {};
  wide_ = {};
  if (chosen != Preconditioner::multilevel) return;
  const auto make_level = [&](auto& level, Buffer<T>& inverse) {
    if (level.aggregates == 0) return;
    weft::make(device, inverse,
               static_cast<std::size_t>(level.domains(own.count)) *
                   static_cast<std::size_t>(level.domain_numbers()));
    level.inverse = inverse.span();
  };
  fine_ = FineLevel<T>::of(partial_rows);
  make_level(fine_, fine_inverse_);
  wide_ = WideLevel<T>::of(partial_rows);
  make_level(wide_, wide_inverse_);
  if (wide_.aggregates > 0)
    weft::make(device, wide_sum_,
               static_cast<std::size_t>(fine_.domains(own.count)) *
                   static_cast<std::size_t>(FineLevel<T>::wide_sums));
}

template <class T>
void PreconditionerBuffers<T>::launch_blocks(Queue& queue, const RankRows& own, const Of& of) {
  launch(queue, Precondition<T>{own.begin,
                                own.count,
                                of.mesh.diagonal,
                                of.contact,
                                of.fixed,
                                {own.block_slice(), inverse_.span()}});
}

template <class T>
void PreconditionerBuffers<T>::launch_levels(Queue& queue, const RankRows& own, const Of& of) {
  if (fine_.aggregates > 0)
    launch(queue, SolveSchwarzLevels<T>{own.begin, of.mesh, of.far, of.contact, of.fixed, fine_,
                                        wide_, wide_sum_.span()});
}

template class PreconditionerBuffers<float>;
template class PreconditionerBuffers<double>;

}  // namespace weft
