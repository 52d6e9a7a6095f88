#pragma once

#include <vector>

#include "host/asynchronous/dop.hpp"
#include "host/asynchronous/workers.hpp"
#include "weft/core/ids.hpp"

namespace weft {

/// Triangles as a complete binary tree of 26-DOPs, halved by the median along the axis in which
/// they lie widest. Node k has the children 2k and 2k + 1; the last level is single triangles.
class Hierarchy {
 public:
  /// @param triangles   cloth first
  /// @param cloth_count how many are cloth; two others never form a pair
  Hierarchy(std::vector<Tri> triangles, std::size_t cloth_count);

  /// Rebuilds the tree from the triangles.
  /// @param x [vertices] [m]
  void build(const std::vector<Vec3<double>>& x);

  /// Fits the nodes to what the triangles sweep.
  /// @param swept [vertices]
  void fit(const std::vector<Dop>& swept, Workers& workers);

  const Dop& of_triangle(std::size_t t) const { return nodes_[leaf_of_[t]]; }

  /// Calls visit(task, s, t) for pairs of triangles, at least one of them cloth, that may come
  /// closer than `distance`.
  /// @param distance as dop_distance() gives it
  /// @param self    false: not for two of cloth
  /// @param prepare is told the number of tasks before any of them; tasks run at once
  template <class Prepare, class Visit>
  void visit(float distance, bool self, Workers& workers, const Prepare& prepare,
             const Visit& visit) const {
    const std::vector<Task> tasks = share_out(distance, self);
    prepare(tasks.size());
    workers.take_turns(tasks.size(), [&](std::size_t k) {
      std::vector<Task> stack{tasks[k]};
      while (!stack.empty()) {
        const Task task = stack.back();
        stack.pop_back();
        if (is_leaf(task.a) && is_leaf(task.b))
          visit(k, triangle_[task.a - leaf_first_], triangle_[task.b - leaf_first_]);
        else
          split(task, distance, self, stack);
      }
    });
  }

 private:
  struct Task {
    std::size_t a, b;  ///< nodes; equal: the pairs within one
  };

  bool is_leaf(std::size_t node) const { return node >= leaf_first_; }
  void build(std::size_t node, std::size_t first, std::size_t last,
             const std::vector<Vec3<double>>& centre);
  void push(std::size_t a, std::size_t b, float distance, bool self, std::vector<Task>& to) const;
  void split(const Task& task, float distance, bool self, std::vector<Task>& to) const;
  std::vector<Task> share_out(float distance, bool self) const;

  std::vector<Tri> triangles_;
  std::size_t cloth_count_;
  std::size_t leaf_first_ = 1;         ///< nodes from here on are leaves
  std::vector<std::size_t> triangle_;  ///< [leaves]; none: triangles_.size()
  std::vector<std::size_t> leaf_of_;   ///< [triangles] its node
  std::vector<Dop> nodes_;
  std::vector<unsigned char> kinds_;  ///< [nodes] 1: has cloth, 2: has others; 0: empty
};

}  // namespace weft
