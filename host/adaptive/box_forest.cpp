#include "host/adaptive/box_forest.hpp"

#include <algorithm>
#include <cstddef>
#include <numeric>

namespace weft {
namespace {

std::size_t at(Index i) {
  return static_cast<std::size_t>(i);
}

Box joined(Box a, const Box& b) {
  a.include(b.lo, b.hi);
  return a;
}

/// Half the sum of the sides, by which boxes are compared.
double girth(const Box& b) {
  return (b.hi[0] - b.lo[0]) + (b.hi[1] - b.lo[1]) + (b.hi[2] - b.lo[2]);
}

}  // namespace

BoxForest::BoxForest(const std::vector<Box>& boxes) {
  leaf_.assign(boxes.size(), -1);
  if (boxes.empty()) return;
  std::vector<Index> items(boxes.size());
  std::iota(items.begin(), items.end(), 0);
  nodes_.reserve(2 * boxes.size());
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

Index BoxForest::build(std::vector<Index>& items, std::size_t first, std::size_t last,
                       const std::vector<Box>& boxes) {
  const Index n = new_node();
  Box box;
  for (std::size_t i = first; i < last; ++i) box = joined(box, boxes[at(items[i])]);
  node(n).box = box;
  if (last - first == 1) {
    node(n).item = items[first];
    leaf_[at(items[first])] = n;
    return n;
  }
  int axis = 0;
  for (int c = 1; c < 3; ++c)
    if (box.hi[c] - box.lo[c] > box.hi[axis] - box.lo[axis]) axis = c;
  const std::size_t middle = first + (last - first) / 2;
  const auto begin = items.begin();
  std::nth_element(begin + static_cast<std::ptrdiff_t>(first),
                   begin + static_cast<std::ptrdiff_t>(middle),
                   begin + static_cast<std::ptrdiff_t>(last), [&](Index a, Index b) {
                     const double x = boxes[at(a)].lo[axis] + boxes[at(a)].hi[axis];
                     const double y = boxes[at(b)].lo[axis] + boxes[at(b)].hi[axis];
                     return x != y ? x < y : a < b;
                   });
  for (int k = 0; k < 2; ++k) {
    const Index child =
        k == 0 ? build(items, first, middle, boxes) : build(items, middle, last, boxes);
    node(n).child[k] = child;
    node(child).parent = n;
  }
  return n;
}

void BoxForest::insert(Index item, const Box& box) {
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
      const Box& child = node(node(n).child[k]).box;
      cost[k] = girth(joined(child, box)) - girth(child);
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
  for (Index up = parent; up >= 0; up = node(up).parent) node(up).box = joined(node(up).box, box);
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
  for (Index up = parent; up >= 0; up = node(up).parent)
    node(up).box = joined(node(node(up).child[0]).box, node(node(up).child[1]).box);
}

}  // namespace weft
