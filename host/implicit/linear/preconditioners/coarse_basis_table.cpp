#include "host/implicit/linear/preconditioners/coarse_basis_table.hpp"

#include <algorithm>
#include <cmath>

namespace weft {
namespace {

/// Extents of an aggregate in material space, and the frame that follows from them.
struct Box {
  Vec2<double> low, high;

  Vec2<double> middle() const { return 0.5 * (low + high); }
  double size() const {
    const double extent = 0.5 * std::max(high[0] - low[0], high[1] - low[1]);
    return extent > 0 ? extent : 1;
  }
};

Box join(const Box& a, const Box& b) {
  return {{std::min(a.low[0], b.low[0]), std::min(a.low[1], b.low[1])},
          {std::max(a.high[0], b.high[0]), std::max(a.high[1], b.high[1])}};
}

/// Boxes of every `count` boxes that follow each other.
std::vector<Box> join_all(const std::vector<Box>& boxes, Index count) {
  std::vector<Box> joined;
  const auto step = static_cast<std::size_t>(count);
  for (std::size_t first = 0; first < boxes.size(); first += step) {
    joined.push_back(boxes[first]);
    for (std::size_t i = first + 1; i < std::min(boxes.size(), first + step); ++i)
      joined.back() = join(joined.back(), boxes[i]);
  }
  return joined;
}

/// Steps from boxes to those around `count` of them.
std::vector<CoarseBasisStep<double>> steps(const std::vector<Box>& boxes,
                                           const std::vector<Box>& larger, Index count) {
  std::vector<CoarseBasisStep<double>> result;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const Box& around = larger[i / static_cast<std::size_t>(count)];
    const Vec2<double> offset = boxes[i].middle() - around.middle();
    result.push_back(
        {offset[0] / around.size(), offset[1] / around.size(), boxes[i].size() / around.size()});
  }
  return result;
}

std::int16_t rounded(double x) {
  return static_cast<std::int16_t>(std::lround(32767 * std::clamp(x, -1.0, 1.0)));
}

}  // namespace

CoarseBasisTable make_coarse_basis_table(const std::vector<Vec2<double>>& points,
                                         Index partial_rows) {
  CoarseBasisTable table;
  table.partial_rows = partial_rows;
  table.unit_rows = coarse_sub_aggregate_rows(partial_rows);
  std::vector<Box> vertices;
  for (const Vec2<double>& p : points) vertices.push_back({p, p});
  const std::vector<Box> units = join_all(vertices, table.unit_rows);
  for (std::size_t v = 0; v < points.size(); ++v) {
    const Box& around = units[v / static_cast<std::size_t>(table.unit_rows)];
    const Vec2<double> place = (1 / around.size()) * (points[v] - around.middle());
    table.point.push_back({rounded(place[0]), rounded(place[1])});
  }
  const Index units_each = partial_rows / table.unit_rows;
  std::vector<Box> boxes = join_all(units, units_each);
  table.unit = steps(units, boxes, units_each);
  while (true) {
    table.aggregates.push_back(static_cast<Index>(boxes.size()));
    if (table.aggregates.back() <= coarse_domain) break;
    const std::vector<Box> larger = join_all(boxes, coarse_domain);
    table.larger.push_back(steps(boxes, larger, coarse_domain));
    boxes = larger;
  }
  return table;
}

}  // namespace weft
