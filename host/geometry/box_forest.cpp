#include "host/geometry/box_forest.hpp"

#include "weft/core/at.hpp"

#include <algorithm>
#include <cstddef>

namespace weft {
namespace {

Aabb joined(Aabb a, const Aabb& b) {
  a.include(b.lo, b.hi);
  return a;
}

bool holds(const Aabb& outer, const Aabb& inner) {
  for (int c = 0; c < 3; ++c)
    if (inner.lo[c] < outer.lo[c] || inner.hi[c] > outer.hi[c]) return false;
  return true;
}

bool same(const Aabb& a, const Aabb& b) {
  return holds(a, b) && holds(b, a);
}

}  // namespace

BoxForest::BoxForest(const std::vector<Aabb>& boxes) {
  leaf_.assign(boxes.size(), -1);
  std::vector<Placed> items;
  items.reserve(boxes.size());
  for (std::size_t i = 0; i < boxes.size(); ++i)
    if (boxes[i].lo[0] <= boxes[i].hi[0])
      items.push_back({boxes[i].lo + boxes[i].hi, static_cast<Index>(i)});
  if (items.empty()) return;
  nodes_.reserve(2 * items.size());
  root_ = build(items, 0, items.size(), boxes);
}

Index BoxForest::new_node() {
  if (!free_.empty()) {
    const Index n = free_.back();
    free_.pop_back();
    node(n) = {};
    return n;
  }
  nodes_.emplace_back();
  return static_cast<Index>(nodes_.size()) - 1;
}

Index BoxForest::build(std::vector<Placed>& items, std::size_t first, std::size_t last,
                       const std::vector<Aabb>& boxes) {
  const Index n = new_node();
  if (last - first == 1) {
    node(n).box = boxes[at(items[first].item)];
    node(n).item = items[first].item;
    leaf_[at(items[first].item)] = n;
    return n;
  }
  const auto begin = items.begin() + static_cast<std::ptrdiff_t>(first);
  const auto end = items.begin() + static_cast<std::ptrdiff_t>(last);
  Aabb centres;
  for (auto it = begin; it != end; ++it) centres.include(it->centre_twice, it->centre_twice);
  int axis = 0;
  for (int c = 1; c < 3; ++c)
    if (centres.hi[c] - centres.lo[c] > centres.hi[axis] - centres.lo[axis]) axis = c;
  const std::size_t middle = first + (last - first) / 2;
  std::nth_element(begin, items.begin() + static_cast<std::ptrdiff_t>(middle), end,
                   [axis](const Placed& a, const Placed& b) {
                     const double x = a.centre_twice[axis], y = b.centre_twice[axis];
                     return x != y ? x < y : a.item < b.item;
                   });
  const Index low = build(items, first, middle, boxes);
  const Index high = build(items, middle, last, boxes);
  node(n).child[0] = low;
  node(n).child[1] = high;
  node(low).parent = node(high).parent = n;
  node(n).box = joined(node(low).box, node(high).box);
  return n;
}

void BoxForest::insert(Index item, const Aabb& box) {
  if (leaf_.size() <= at(item)) leaf_.resize(at(item) + 1, -1);
  const Index leaf = new_node();
  node(leaf).box = box;
  node(leaf).item = item;
  leaf_[at(item)] = leaf;
  if (root_ < 0) {
    root_ = leaf;
    return;
  }
  Index n = root_;
  while (node(n).item < 0) {
    double cost[2];
    for (int k = 0; k < 2; ++k) {
      const Aabb& child = node(node(n).child[k]).box;
      cost[k] = joined(child, box).girth() - child.girth();
    }
    n = node(n).child[cost[1] < cost[0] ? 1 : 0];
  }
  const Index parent = node(n).parent;
  const Index fork = new_node();
  node(fork).parent = parent;
  node(fork).child[0] = n;
  node(fork).child[1] = leaf;
  node(n).parent = fork;
  node(leaf).parent = fork;
  if (parent < 0)
    root_ = fork;
  else
    node(parent).child[node(parent).child[0] == n ? 0 : 1] = fork;
  node(fork).box = joined(node(n).box, box);
  for (Index up = parent; up >= 0 && !holds(node(up).box, box); up = node(up).parent)
    node(up).box = joined(node(up).box, box);
}

void BoxForest::remove(Index item) {
  const Index leaf = leaf_[at(item)];
  leaf_[at(item)] = -1;
  const Index fork = node(leaf).parent;
  free_.push_back(leaf);
  if (fork < 0) {
    root_ = -1;
    return;
  }
  const Index other = node(fork).child[node(fork).child[0] == leaf ? 1 : 0];
  const Index parent = node(fork).parent;
  node(other).parent = parent;
  free_.push_back(fork);
  if (parent < 0)
    root_ = other;
  else
    node(parent).child[node(parent).child[0] == fork ? 0 : 1] = other;
  tighten(parent);
}

void BoxForest::replace(Index item, const Aabb& box) {
  const Index leaf = leaf_[at(item)];
  node(leaf).box = box;
  tighten(node(leaf).parent);
}

void BoxForest::tighten(Index n) {
  for (; n >= 0; n = node(n).parent) {
    const Aabb box = joined(node(node(n).child[0]).box, node(node(n).child[1]).box);
    if (same(box, node(n).box)) return;
    node(n).box = box;
  }
}

}  // namespace weft
