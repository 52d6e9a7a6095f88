#include "weft/kernels/collide/out_of_bounds.hpp"

#include "host/exec/host_device.hpp"

namespace weft {

template <class T>
void run(OnHost, Queue& queue, const CollideStray<T>& args) {
  submit_host(queue, [args] {
    Index escaped = 0;
    for (Index v = args.vertex_begin; v < args.vertex_end; ++v)
      if (!keeps_to_its_box(args, v)) ++escaped;
    args.counts[0].escaped = escaped;
  });
}

template void run(OnHost, Queue&, const CollideStray<float>&);
template void run(OnHost, Queue&, const CollideStray<double>&);

}  // namespace weft
