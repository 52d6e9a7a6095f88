#pragma once

#include <string>
#include <typeinfo>

#include "weft/error.hpp"
#include "weft/exec/device.hpp"

namespace weft {

struct OnHost {};
struct OnCuda {};

/// Submits the kernel that `args` describes to `queue`, on the queue's backend. The kernel is found
/// by overload: run(OnHost, Queue&, const Args&) in host/, run(OnCuda, Queue&, const Args&) in
/// cuda/.
/// @throws DeviceError if this build has no twin of the kernel for the backend
template <class Args>
void launch(Queue& queue, const Args& args) {
  if (queue.backend() == Backend::host) {
    run(OnHost{}, queue, args);
    return;
  }
#if defined(WEFT_CUDA)
  if constexpr (requires { run(OnCuda{}, queue, args); }) {
    run(OnCuda{}, queue, args);
    return;
  }
#endif
  throw DeviceError(std::string("this build has no CUDA kernel for ") + typeid(Args).name());
}

}  // namespace weft
