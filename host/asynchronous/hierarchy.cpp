#include "host/asynchronous/hierarchy.hpp"

#include "weft/core/at.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace weft {
namespace {

/// Work is shared out in at least so many parts, whatever the number of threads.
constexpr std::size_t tasks_wanted = 256;
constexpr std::size_t least_nodes_per_thread = 256;

}  // namespace

Hierarchy::Hierarchy(std::vector<Tri> triangles, std::size_t cloth_count)
    : triangles_(std::move(triangles)), cloth_count_(cloth_count), leaf_of_(triangles_.size(), 0) {
  while (leaf_first_ < triangles_.size()) leaf_first_ *= 2;
  nodes_.resize(2 * leaf_first_);
  kinds_.assign(2 * leaf_first_, 0);
  triangle_.assign(leaf_first_, triangles_.size());
}

void Hierarchy::build(const std::vector<Vec3<double>>& x) {
  std::vector<Vec3<double>> centre;
  centre.reserve(triangles_.size());
  for (const Tri& t : triangles_) centre.push_back(x[at(t.v[0])] + x[at(t.v[1])] + x[at(t.v[2])]);
  std::vector<std::size_t> order(triangles_.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  triangle_ = std::move(order);
  build(1, 0, triangles_.size(), centre);
  // Leaves are as many on either side of a node, or one more: place them on the last level.
  std::vector<std::size_t> leaves(leaf_first_, triangles_.size());
  for (std::size_t k = 0; k < leaf_first_; ++k) {
    const std::size_t first = triangles_.size() * k / leaf_first_;
    const std::size_t last = triangles_.size() * (k + 1) / leaf_first_;
    if (first < last) leaves[k] = triangle_[first];
  }
  triangle_ = std::move(leaves);
  std::fill(kinds_.begin(), kinds_.end(), static_cast<unsigned char>(0));
  for (std::size_t k = 0; k < leaf_first_; ++k) {
    if (triangle_[k] == triangles_.size()) continue;
    leaf_of_[triangle_[k]] = leaf_first_ + k;
    kinds_[leaf_first_ + k] = triangle_[k] < cloth_count_ ? 1 : 2;
  }
  for (std::size_t n = leaf_first_; n-- > 1;)
    kinds_[n] = static_cast<unsigned char>(kinds_[2 * n] | kinds_[2 * n + 1]);
}

/// Node n of a level of `width` nodes holds the triangles count * place / width and on, so that
/// the last level holds at most one each.
void Hierarchy::build(std::size_t node, std::size_t first, std::size_t last,
                      const std::vector<Vec3<double>>& centre) {
  if (node >= leaf_first_ || last - first < 2) return;
  std::size_t width = 1;
  while (2 * width <= node) width *= 2;
  const std::size_t middle = triangles_.size() * (2 * (node - width) + 1) / (2 * width);
  Extent extent;
  for (std::size_t i = first; i < last; ++i) extent.include(centre[triangle_[i]]);
  int axis = 0;
  for (int k = 1; k < 3; ++k)
    if (extent.hi[k] - extent.lo[k] > extent.hi[axis] - extent.lo[axis]) axis = k;
  const auto begin = triangle_.begin();
  std::nth_element(begin + static_cast<std::ptrdiff_t>(first),
                   begin + static_cast<std::ptrdiff_t>(middle),
                   begin + static_cast<std::ptrdiff_t>(last), [&](std::size_t a, std::size_t b) {
                     const double p = centre[a][axis], q = centre[b][axis];
                     return p != q ? p < q : a < b;
                   });
  build(2 * node, first, middle, centre);
  build(2 * node + 1, middle, last, centre);
}

void Hierarchy::fit(const std::vector<Dop>& swept, Workers& workers) {
  workers.share(leaf_first_, least_nodes_per_thread, [&](std::size_t a, std::size_t b) {
    for (std::size_t k = a; k < b; ++k) {
      Dop dop;
      if (triangle_[k] < triangles_.size())
        for (const Index v : triangles_[triangle_[k]].v) dop.include(swept[at(v)]);
      nodes_[leaf_first_ + k] = dop;
    }
  });
  for (std::size_t first = leaf_first_ / 2; first > 0; first /= 2)
    workers.share(first, least_nodes_per_thread, [&](std::size_t a, std::size_t b) {
      for (std::size_t n = first + a; n < first + b; ++n) {
        nodes_[n] = nodes_[2 * n];
        nodes_[n].include(nodes_[2 * n + 1]);
      }
    });
}

void Hierarchy::push(std::size_t a, std::size_t b, float distance, bool self,
                     std::vector<Task>& to) const {
  const unsigned char both = kinds_[a] | kinds_[b];
  if (kinds_[a] == 0 || kinds_[b] == 0 || (both & 1) == 0) return;
  if (!self && (both & 2) == 0) return;
  if (a == b && is_leaf(a)) return;  // corners of one triangle
  if (a != b && nodes_[a].farther(nodes_[b], distance)) return;
  to.push_back({a, b});
}

void Hierarchy::split(const Task& task, float distance, bool self, std::vector<Task>& to) const {
  const auto [a, b] = task;
  if (a == b) {
    push(2 * a, 2 * a, distance, self, to);
    push(2 * a + 1, 2 * a + 1, distance, self, to);
    push(2 * a, 2 * a + 1, distance, self, to);
  } else if (is_leaf(b) || (!is_leaf(a) && a <= b)) {
    push(2 * a, b, distance, self, to);
    push(2 * a + 1, b, distance, self, to);
  } else {
    push(a, 2 * b, distance, self, to);
    push(a, 2 * b + 1, distance, self, to);
  }
}

std::vector<Hierarchy::Task> Hierarchy::share_out(float distance, bool self) const {
  std::vector<Task> tasks;
  push(1, 1, distance, self, tasks);
  while (!tasks.empty() && tasks.size() < tasks_wanted) {
    std::vector<Task> next;
    bool split_any = false;
    for (const Task& task : tasks) {
      if (is_leaf(task.a) && is_leaf(task.b)) {
        next.push_back(task);
        continue;
      }
      split(task, distance, self, next);
      split_any = true;
    }
    tasks = std::move(next);
    if (!split_any) break;
  }
  return tasks;
}

}  // namespace weft
