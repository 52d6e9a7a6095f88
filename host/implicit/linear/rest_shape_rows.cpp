#include "host/implicit/linear/rest_shape_rows.hpp"

#include <algorithm>

namespace weft {
namespace {

/// For each row the numbers of those of `vertices` that are the row's, ascending.
void gather(const std::vector<Index>& vertices, Index begin, Index end, std::vector<Offset>& offset,
            std::vector<Index>& source) {
  offset.assign(static_cast<std::size_t>(end - begin) + 1, 0);
  for (const Index v : vertices)
    if (v >= begin && v < end) ++offset[static_cast<std::size_t>(v - begin) + 1];
  for (std::size_t r = 1; r < offset.size(); ++r) offset[r] += offset[r - 1];
  std::vector<Offset> place(offset.begin(), offset.end() - 1);
  source.resize(static_cast<std::size_t>(offset.back()));
  for (std::size_t n = 0; n < vertices.size(); ++n)
    if (vertices[n] >= begin && vertices[n] < end)
      source[static_cast<std::size_t>(place[static_cast<std::size_t>(vertices[n] - begin)]++)] =
          static_cast<Index>(n);
}

}  // namespace

RestShapeRows make_rest_shape_rows(const PlateShape& shape, const Partition& partition, int rank) {
  const Index begin = partition.row_begin[static_cast<std::size_t>(rank)];
  const Index end = partition.row_begin[static_cast<std::size_t>(rank) + 1];
  RestShapeRows rows;
  std::vector<Index> corner_vertices;
  rows.offset.push_back(0);
  for (std::size_t t = 0; t < shape.corners.size(); ++t) {
    const auto first = shape.vertex.begin() + static_cast<std::ptrdiff_t>(shape.offset[t]);
    const auto last = shape.vertex.begin() + static_cast<std::ptrdiff_t>(shape.offset[t + 1]);
    // The corners are among the vertices.
    if (std::none_of(first, last, [&](Index v) { return v >= begin && v < end; })) continue;
    rows.entry_triangle.insert(rows.entry_triangle.end(), static_cast<std::size_t>(last - first),
                               static_cast<Index>(rows.corners.size()));
    rows.vertex.insert(rows.vertex.end(), first, last);
    rows.force.insert(rows.force.end(),
                      shape.force.begin() + static_cast<std::ptrdiff_t>(shape.offset[t]),
                      shape.force.begin() + static_cast<std::ptrdiff_t>(shape.offset[t + 1]));
    rows.offset.push_back(static_cast<Offset>(rows.vertex.size()));
    rows.corners.push_back(shape.corners[t]);
    rows.inv_rest.push_back(shape.inv_rest[t]);
    corner_vertices.insert(corner_vertices.end(), shape.corners[t].v, shape.corners[t].v + 3);
  }
  if (rows.corners.empty()) return {};
  gather(rows.vertex, begin, end, rows.entry_offset, rows.entry);
  gather(corner_vertices, begin, end, rows.corner_offset, rows.corner);
  return rows;
}

}  // namespace weft
