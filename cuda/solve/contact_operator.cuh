#pragma once

#include <cuda_runtime.h>

#include "weft/state/contact_operator.hpp"

namespace weft::cuda {

/// The pull of a link in a product with v. Rounded alike wherever it stands: see fused_dot().
template <class T>
__device__ Vec3<T> pull_of(const ContactOperatorEntry<T>& link, const Vec3<T>* v) {
  Vec3<T> d{};
#pragma unroll
  for (int j = 0; j < 4; ++j) {
    const Vec3<T> x = v[link.v[j]];
    for (int c = 0; c < 3; ++c) d[c] = fma(link.w[j], x[c], d[c]);
  }
  const T* b = link.block;
  return {fma(b[2], d[2], fma(b[1], d[1], b[0] * d[0])),
          fma(b[4], d[2], fma(b[3], d[1], b[1] * d[0])),
          fma(b[5], d[2], fma(b[4], d[1], b[2] * d[0]))};
}

/// Pulls of all links in a product with v, shared out evenly however rows share the links.
/// @param block, blocks of those that share them
template <class T>
__device__ void gather_contacts(const ContactOperator<T>& links, int block, int blocks,
                                const Vec3<T>* v) {
  const Index count = links.count.data()[0];
  const auto stride = static_cast<Index>(blocks) * static_cast<Index>(blockDim.x);
  for (Index n = block * static_cast<Index>(blockDim.x) + static_cast<Index>(threadIdx.x);
       n < count; n += stride)
    links.pull.data()[n].x = pull_of(links.link.data()[n], v);
}

/// Row `row` of the contact part times v.
/// @tparam pulled the pulls are there; else each end recomputes its link's, to the same bits
template <bool pulled, class T>
__device__ Vec3<T> contact_row(const ContactOperator<T>& links, Index row, const Vec3<T>* v) {
  // Loads under way; a pull that is yet to be found has enough of its own. Those beyond the last
  // end are asked for as well: with branches around them the compiler spills the solve's registers.
  constexpr int together = pulled ? 4 : 1;
  Vec3<T> sum{};
  const Index first = links.end_offset.data()[row];
  const Index last = links.end_offset.data()[row + 1];
#pragma unroll 1
  for (Index e = first; e < last; e += together) {
    ContactScatter<T> end[together];
    ContactGather<T> pull[together];
#pragma unroll
    for (int k = 0; k < together; ++k) end[k] = links.end.data()[min(e + k, last - 1)];
#pragma unroll
    for (int k = 0; k < together; ++k) {
      if constexpr (pulled)
        pull[k] = links.pull.data()[end[k].link];
      else
        pull[k].x = pull_of(links.link.data()[end[k].link], v);
    }
#pragma unroll
    for (int k = 0; k < together; ++k)
      if (e + k < last)
        for (int c = 0; c < 3; ++c) sum[c] = fma(end[k].weight, pull[k].x[c], sum[c]);
  }
  return sum;
}

}  // namespace weft::cuda
