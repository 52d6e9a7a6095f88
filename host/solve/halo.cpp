#include "weft/kernels/solve/halo.hpp"

#include <algorithm>

#include "host/exec/host_device.hpp"

namespace weft {
namespace {

template <class T>
void list_ghosts(const SolveHalo<T>& a) {
  const Index begin = a.row_begin[static_cast<std::size_t>(a.rank)];
  const Index end = a.row_begin[static_cast<std::size_t>(a.rank) + 1];
  std::size_t count = 0;
  const auto add = [&](Index vertex) {
    Index& stamp = a.stamp[static_cast<std::size_t>(vertex)];
    if (stamp == a.epoch) return;
    stamp = a.epoch;
    a.ghost[count++] = vertex;
  };
  for (const Index vertex : a.mesh_ghost) add(vertex);
  const Index links = a.contact.count.empty() ? 0 : a.contact.count[0];
  for (Index n = 0; n < links; ++n)
    for (const Index vertex : a.contact.link.data()[n].v)
      if (vertex < begin || vertex >= end) add(vertex);
  std::sort(a.ghost.begin(), a.ghost.begin() + count);
  a.ghost_offset[0] = 0;
  for (std::size_t owner = 0; owner + 1 < a.row_begin.size(); ++owner)
    a.ghost_offset[owner + 1] = static_cast<Index>(
        std::lower_bound(a.ghost.begin(), a.ghost.begin() + count, a.row_begin[owner + 1]) -
        a.ghost.begin());
}

}  // namespace

template <class T>
void run(OnHost, Queue& queue, const SolveHalo<T>& args) {
  submit_host(queue, [args] { list_ghosts(args); });
}

template void run(OnHost, Queue&, const SolveHalo<float>&);
template void run(OnHost, Queue&, const SolveHalo<double>&);

}  // namespace weft
