#include "host/implicit/linear/krylov_vectors.hpp"

namespace weft {

template <class T>
void KrylovVectors<T>::make(Device& device, const RankRows& own, Index vertices, int ranks,
                            Index partial_rows) {
  const MemoryName name("solver");
  const auto rows = static_cast<std::size_t>(own.count);
  const auto cloth = static_cast<std::size_t>(vertices);
  for (auto* vector : {&mesh_rhs, &rhs, &r, &w, &p, &s}) weft::make(device, *vector, rows);
  weft::make(device, x, cloth);
  weft::make(device, u, cloth);
  weft::make(device, stamp, cloth);
  weft::make(device, ghost, cloth);
  weft::make(device, ghost_offset, static_cast<std::size_t>(ranks) + 1);
  weft::make(device, partial, 6 * static_cast<std::size_t>(pcg_partials(vertices, partial_rows)));
  weft::make(device, ready, pcg_flags);
  weft::make(device, receivers, ranks > 1 ? rows : 0);
  weft::make(device, status, 1);
  weft::make(device, parts, static_cast<std::size_t>(ranks));
  device.compute().fill(stamp.data(), 0, cloth * sizeof(Index));
  device.compute().fill(ready.data(), 0, pcg_flags * sizeof(std::uint32_t));
  device.compute().sync();
}

template <class T>
void KrylovVectors<T>::fill(SolvePcgPart<T>& part) const {
  part.rhs = rhs.span();
  part.ghost = ghost.span();
  part.ghost_offset = ghost_offset.span();
  part.x = x.span();
  part.u = u.span();
  part.r = r.span();
  part.w = w.span();
  part.p = p.span();
  part.s = s.span();
  part.partial = partial.span();
  part.ready = ready.span();
  part.receivers = receivers.span();
  part.status = status.span();
}

template struct KrylovVectors<float>;
template struct KrylovVectors<double>;

}  // namespace weft
