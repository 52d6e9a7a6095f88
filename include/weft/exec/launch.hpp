#pragma once

#include <string>
#include <typeinfo>
#include <vector>

#include "weft/error.hpp"
#include "weft/exec/device.hpp"
#include "weft/exec/launch_observer.hpp"

namespace weft {

struct OnHost {};
struct OnCuda {};

/// launch() without an observer.
template <class Args>
void launch_unobserved(Queue& queue, const Args& args) {
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

/// Submits the kernel that `args` describes to `queue`, on the queue's backend. The kernel is found
/// by overload: run(OnHost, Queue&, const Args&) in host/, run(OnCuda, Queue&, const Args&) in
/// cuda/.
/// @throws DeviceError if this build does not have the kernel for the backend
template <class Args>
void launch(Queue& queue, const Args& args) {
  LaunchObserver* observer = LaunchObserver::current;
  if (observer != nullptr) observer->before(queue);
  launch_unobserved(queue, args);
  if (observer != nullptr) observer->after(queue, typeid(Args), &args);
}

/// Submits a collective kernel, whose ranks wait for each other: args[r] to the compute queue of
/// rank r. Ranks that share a GPU become one launch, since kernels that wait for each other there
/// have no promise to run at the same time: run(OnCuda, DeviceSet&, const std::vector<Args>&).
/// @param args [ranks]
/// @throws DeviceError if this build does not have the kernel for the backend
template <class Args>
void launch_collective(DeviceSet& devices, const std::vector<Args>& args) {
#if defined(WEFT_CUDA)
  if (devices.backend() == Backend::cuda)
    if constexpr (requires { run(OnCuda{}, devices, args); }) {
      LaunchObserver* observer = LaunchObserver::current;
      Queue& queue = devices[0].compute();
      if (observer != nullptr) observer->before(queue);
      run(OnCuda{}, devices, args);
      if (observer != nullptr) observer->after(queue, typeid(Args), &args.front());
      return;
    }
#endif
  for (int r = 0; r < devices.size(); ++r)
    launch(devices[r].compute(), args[static_cast<std::size_t>(r)]);
}

}  // namespace weft
