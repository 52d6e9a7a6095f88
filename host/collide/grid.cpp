#include "weft/kernels/collide/grid.hpp"

#include <algorithm>
#include <cstdint>

#include "host/exec/host_device.hpp"

namespace weft {
namespace {

template <class Visit>
void for_each_place(const Box& box, float cell, std::uint32_t buckets, Visit visit) {
  const PlacesOf places = places_of(box, cell);
  for (int n = 0; n < places.count; ++n) visit(places(n, buckets), places.level);
}

void build_grid(const CollideGrid& a) {
  if (!a.wanted.empty() && a.wanted[0] == 0) return;
  const float cell = level_0_cell(a);
  const auto buckets = static_cast<std::uint32_t>(a.bucket_offset.size() - 1);
  std::uint32_t levels = 0;
  std::fill(a.bucket_offset.begin(), a.bucket_offset.end(), 0);
  for (std::size_t i = 0; i < a.boxes.size(); ++i)
    for_each_place(a.boxes[i], cell, buckets, [&](const GridPlace& place, int level) {
      ++a.bucket_offset.data()[place.bucket + 1];
      levels |= 1u << level;
    });
  for (std::size_t b = 0; b < buckets; ++b) a.bucket_offset[b + 1] += a.bucket_offset[b];
  for (std::size_t i = 0; i < a.boxes.size(); ++i)
    for_each_place(a.boxes[i], cell, buckets, [&](const GridPlace& place, int) {
      a.entries.data()[a.bucket_offset.data()[place.bucket]++] = {place.tag, static_cast<Index>(i),
                                                                  a.boxes[i]};
    });
  // Filling moved each start to the next one's place; move them back.
  for (std::size_t b = buckets; b > 0; --b) a.bucket_offset[b] = a.bucket_offset[b - 1];
  a.bucket_offset[0] = 0;
  a.levels[0] = levels;
  a.cell[0] = cell;
}

}  // namespace

void run(OnHost, Queue& queue, const CollideGrid& args) {
  submit_host(queue, [args] { build_grid(args); });
}

}  // namespace weft
