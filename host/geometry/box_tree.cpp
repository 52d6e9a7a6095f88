#include "host/geometry/box_tree.hpp"

#include <algorithm>
#include <utility>

#include "host/base/parallel.hpp"

namespace weft {
namespace {

Aabb box_of(Span<const Vec3<double>> points, const Tri& t) {
  Aabb box;
  for (const Index v : t.v) box.include(points[static_cast<std::size_t>(v)]);
  return box;
}

Aabb padded(const Aabb& box, double pad) {
  const Vec3<double> corner{pad, pad, pad};
  return {box.lo - corner, box.hi + corner};
}

}  // namespace

BoxTree::BoxTree(Span<const Vec3<double>> points, Span<const Tri> triangles, Index first,
                 Index last, double relative_pad) {
  items.reserve(static_cast<std::size_t>(last - first));
  for (Index t = first; t < last; ++t) {
    const Aabb box = box_of(points, triangles[static_cast<std::size_t>(t)]);
    items.push_back({padded(box, relative_pad * box.longest_side()), t});
  }
  while (4 * leaf_count < items.size()) leaf_count *= 2;
  nodes.resize(2 * leaf_count);
  leaf_first.assign(leaf_count + 1, items.size());
  build_all();
  item_awake.assign(items.size(), 1);
  node_awake.assign(nodes.size(), 1);
}

/// Level by level until there is a node for each thread, then one thread a node and what is below
/// it: the same tree with any number of threads.
void BoxTree::build_all() {
  const unsigned threads = setup_threads(items.size());
  std::vector<Run> runs{{1, 0, items.size()}};
  while (runs.size() < 4 * threads && threads > 1 && runs.front().node < leaf_count) {
    std::vector<Run> below(2 * runs.size());
    for_each_index(threads, runs.size(), [&](std::size_t k) {
      const auto [node, first, last] = runs[k];
      const std::size_t middle = halve(runs[k]);
      below[2 * k] = {2 * node, first, middle};
      below[2 * k + 1] = {2 * node + 1, middle, last};
    });
    runs = std::move(below);
  }
  for_each_index(threads, runs.size(), [&](std::size_t k) { build(runs[k]); });
}

void BoxTree::build(const Run& run) {
  const auto [node, first, last] = run;
  const std::size_t middle = halve(run);
  if (node >= leaf_count) return;
  build({2 * node, first, middle});
  build({2 * node + 1, middle, last});
}

/// Sets the node's box; of an inner node also puts the items of its halves apart.
/// @return where the second half begins
std::size_t BoxTree::halve(const Run& run) {
  const auto [node, first, last] = run;
  Aabb& box = nodes[node];
  for (std::size_t i = first; i < last; ++i) box.include(items[i].box.lo, items[i].box.hi);
  if (node >= leaf_count) {
    leaf_first[node - leaf_count] = first;
    return last;
  }
  const Vec3<double> span = box.hi - box.lo;
  const int axis = span[0] >= span[1] ? (span[0] >= span[2] ? 0 : 2) : (span[1] >= span[2] ? 1 : 2);
  const std::size_t middle = first + (last - first) / 2;
  const auto begin = items.begin();
  std::nth_element(
      begin + static_cast<std::ptrdiff_t>(first), begin + static_cast<std::ptrdiff_t>(middle),
      begin + static_cast<std::ptrdiff_t>(last),
      [&](const Item& a, const Item& b) { return a.centre_twice(axis) < b.centre_twice(axis); });
  return middle;
}

void BoxTree::refit(Span<const Vec3<double>> points, Span<const Tri> triangles, double pad,
                    Span<const unsigned char> point_awake) {
  refit_by(
      points, triangles, [pad](std::size_t) { return pad; }, point_awake);
}

void BoxTree::refit(Span<const Vec3<double>> points, Span<const Tri> triangles,
                    Span<const double> pads, Span<const unsigned char> point_awake) {
  refit_by(
      points, triangles, [pads](std::size_t t) { return pads[t]; }, point_awake);
}

template <class PadOf>
void BoxTree::refit_by(Span<const Vec3<double>> points, Span<const Tri> triangles,
                       const PadOf& pad_of, Span<const unsigned char> point_awake) {
  for (std::size_t i = 0; i < items.size(); ++i) {
    const auto number = static_cast<std::size_t>(items[i].triangle);
    const Tri& t = triangles[number];
    items[i].box = padded(box_of(points, t), pad_of(number));
    item_awake[i] = 0;
    for (const Index v : t.v)
      if (point_awake[static_cast<std::size_t>(v)] != 0) item_awake[i] = 1;
  }
  for (std::size_t node = nodes.size(); node-- > 1;) {
    nodes[node] = Aabb{};
    node_awake[node] = 0;
    if (node < leaf_count) {
      for (std::size_t child = 2 * node; child < 2 * node + 2; ++child) {
        nodes[node].include(nodes[child].lo, nodes[child].hi);
        node_awake[node] |= node_awake[child];
      }
      continue;
    }
    for (std::size_t i = leaf_first[node - leaf_count]; i < leaf_first[node - leaf_count + 1];
         ++i) {
      nodes[node].include(items[i].box.lo, items[i].box.hi);
      node_awake[node] |= item_awake[i];
    }
  }
}

}  // namespace weft
