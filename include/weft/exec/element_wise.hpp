#pragma once

#include <concepts>

#include "weft/core/ids.hpp"
#include "weft/exec/launch.hpp"

namespace weft {

/// Arguments of a kernel that does one thing per item: args(i) for i = 0 to args.count() - 1, in
/// any order. weft/kernels/element_wise.hpp lists these kernels; each backend has one loop for all.
template <class Args>
concept ElementWise = requires(const Args& args, Index i) {
  { args.count() } -> std::same_as<Index>;
  { args(i) }
  noexcept;
};

template <ElementWise Args>
void run(OnHost, Queue& queue, const Args& args);
template <ElementWise Args>
void run(OnCuda, Queue& queue, const Args& args);

}  // namespace weft
