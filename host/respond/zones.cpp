#include "weft/kernels/respond/zones.hpp"

#include <algorithm>
#include <vector>

#include "host/exec/host_device.hpp"
#include "weft/kernels/respond/zone/alone.hpp"
#include "weft/kernels/respond/zone/solver.hpp"

namespace weft {
template <class T>
void run(OnHost, Queue& queue, const RespondZones<T>& args) {
  submit_host(queue, [args] {
    Alone alone{args.stop};
    ZoneSolver<T, Alone> solver(args, alone);
    std::vector<std::byte> memory;
    for (std::size_t z = 0; z < args.outcomes.size(); ++z) {
      const auto collisions = static_cast<std::size_t>(args.zone_begin[z + 1] - args.zone_begin[z]);
      memory.resize(std::max(memory.size(), zone_scratch_bytes(collisions, 1)));
      solver.solve(static_cast<Index>(z), memory.data());
    }
  });
}

template void run(OnHost, Queue&, const RespondZones<float>&);
template void run(OnHost, Queue&, const RespondZones<double>&);

}  // namespace weft
