#pragma once

#include "host/exec/host_device.hpp"
#include "weft/core/ids.hpp"

namespace weft {

/// Submits `body(args, i)` for i = 0 to count - 1, in order, as one piece of work.
template <class Args, class Body>
void submit_for_each(Queue& queue, const Args& args, Index count, Body body) {
  submit_host(queue, [args, count, body] {
    for (Index i = 0; i < count; ++i) body(args, i);
  });
}

}  // namespace weft
