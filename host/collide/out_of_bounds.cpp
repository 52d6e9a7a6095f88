#include "weft/kernels/collide/out_of_bounds.hpp"

#include "host/exec/host_device.hpp"

namespace weft {

template <class T>
void run(OnHost, Queue& queue, const CollideOutOfBounds<T>& args) {
  submit_host(queue, [args] {
    Index out_of_bounds = 0;
    for (Index v = args.vertex_begin; v < args.vertex_end; ++v)
      if (!keeps_to_its_box(args, v)) ++out_of_bounds;
    args.counts[0].out_of_bounds = out_of_bounds;
  });
}

template void run(OnHost, Queue&, const CollideOutOfBounds<float>&);
template void run(OnHost, Queue&, const CollideOutOfBounds<double>&);

}  // namespace weft
