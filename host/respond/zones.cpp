#include "weft/kernels/respond/zones.hpp"

#include <algorithm>
#include <vector>

#include "host/exec/host_device.hpp"
#include "weft/kernels/respond/zone/solver.hpp"

namespace weft {
namespace {

/// A team of one.
struct Alone {
  static constexpr bool alone = true;
  static constexpr bool in_order = true;
  static constexpr bool at_once = false;
  static constexpr Index lanes = 1;
  static constexpr Index rank() { return 0; }
  static constexpr Index size() { return 1; }
  static void sync() {}
  static double sum(double value) { return value; }
  static double largest(double value) { return value; }
  static bool any(bool value) { return value; }
  static Index before(Index value, Index& total) {
    total = value;
    return 0;
  }
  static void sort(Offset* keys, Index count) { std::sort(keys, keys + count); }
};

}  // namespace

template <class T>
void run(OnHost, Queue& queue, const RespondZones<T>& args) {
  submit_host(queue, [args] {
    Alone alone;
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
