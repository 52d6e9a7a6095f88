#include "host/lab/check/intersections.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <thread>

#include "host/lab/check/box_tree.hpp"
#include "host/lab/check/triangle_pair.hpp"

namespace weft::lab {
namespace {

Corners corners(const Mesh& mesh, Index triangle) {
  const Tri& t = mesh.triangles[static_cast<std::size_t>(triangle)];
  return {mesh.positions[static_cast<std::size_t>(t.v[0])],
          mesh.positions[static_cast<std::size_t>(t.v[1])],
          mesh.positions[static_cast<std::size_t>(t.v[2])]};
}

Box box_of(const Mesh& mesh, Index triangle) {
  const Corners c = corners(mesh, triangle);
  return join(join({c[0], c[0]}, {c[1], c[1]}), {c[2], c[2]});
}

std::vector<Box> boxes_of(const Mesh& mesh, const std::vector<Index>& ids) {
  std::vector<Box> boxes;
  boxes.reserve(ids.size());
  for (const Index i : ids) boxes.push_back(box_of(mesh, i));
  return boxes;
}

/// Counts pairs and keeps the lowest ones, in memory that does not grow with the count.
class PairCollector {
 public:
  explicit PairCollector(std::size_t limit) : limit_(limit) {}

  void add(const TrianglePair& pair) {
    ++count_;
    pairs_.push_back(pair);
    if (pairs_.size() >= 2 * limit_ + 1024) trim();
  }
  void add(const PairCollector& other) {
    count_ += other.count_;
    pairs_.insert(pairs_.end(), other.pairs_.begin(), other.pairs_.end());
    trim();
  }
  std::int64_t count() const { return count_; }
  /// The lowest pairs, sorted.
  const std::vector<TrianglePair>& pairs() const { return pairs_; }

 private:
  void trim() {
    std::sort(pairs_.begin(), pairs_.end());
    if (pairs_.size() > limit_) pairs_.resize(limit_);
  }

  std::size_t limit_;
  std::int64_t count_ = 0;
  std::vector<TrianglePair> pairs_;
};

/// Runs work(begin, end, collector) over [0, size) in blocks on `threads` workers and joins what
/// they found. The result does not depend on who took which block.
template <class Work>
PairCollector collect(std::size_t size, const ValidatorOptions& options, Work&& work) {
  constexpr std::size_t block = 256;
  const std::size_t workers = std::min(static_cast<std::size_t>(std::max(options.threads, 1)),
                                       std::max<std::size_t>(size / block, 1));
  std::vector<PairCollector> found(workers, PairCollector(options.list_limit));
  std::vector<std::exception_ptr> failures(workers);
  std::atomic<std::size_t> next{0};
  const auto run = [&](std::size_t worker) {
    try {
      for (std::size_t begin; (begin = next.fetch_add(block)) < size;)
        work(begin, std::min(begin + block, size), found[worker]);
    } catch (...) {
      failures[worker] = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> threads;
    for (std::size_t w = 1; w < workers; ++w) threads.emplace_back(run, w);
    run(0);
  }
  for (const auto& failure : failures)
    if (failure) std::rethrow_exception(failure);
  PairCollector all(options.list_limit);
  for (const auto& part : found) all.add(part);
  return all;
}

PairCollector cloth_pairs(const Mesh& cloth, const std::vector<Index>& ids,
                          const ValidatorOptions& options) {
  const BoxTree tree(boxes_of(cloth, ids), ids);
  const auto work = [&](std::size_t begin, std::size_t end, PairCollector& found) {
    for (std::size_t leaf = begin; leaf < end; ++leaf)
      tree.pairs_from_leaf(leaf, [&](Index i, Index j) {
        const auto [a, b] = std::minmax(i, j);
        if (intersect(cloth.positions.data(), cloth.triangles[static_cast<std::size_t>(a)],
                      cloth.triangles[static_cast<std::size_t>(b)]))
          found.add({PairKind::cloth_cloth, a, b});
      });
  };
  return collect(tree.leaf_count(), options, work);
}

PairCollector obstacle_pairs(const Mesh& cloth, const std::vector<Index>& cloth_ids,
                             const Mesh& obstacle, const std::vector<Index>& obstacle_ids,
                             const ValidatorOptions& options) {
  const BoxTree tree(boxes_of(obstacle, obstacle_ids), obstacle_ids);
  const auto work = [&](std::size_t begin, std::size_t end, PairCollector& found) {
    for (std::size_t k = begin; k < end; ++k) {
      const Index a = cloth_ids[k];
      tree.overlapping(box_of(cloth, a), [&](Index b) {
        if (triangles_meet(corners(cloth, a), corners(obstacle, b)))
          found.add({PairKind::cloth_obstacle, a, b});
      });
    }
  };
  return collect(cloth_ids.size(), options, work);
}

}  // namespace

std::vector<Index> finite_triangles(const Mesh& mesh) {
  std::vector<Index> ids;
  ids.reserve(mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    bool finite = true;
    for (const auto& x : corners(mesh, static_cast<Index>(i)))
      finite = finite && std::isfinite(x[0]) && std::isfinite(x[1]) && std::isfinite(x[2]);
    if (finite) ids.push_back(static_cast<Index>(i));
  }
  return ids;
}

void find_intersections(const Mesh& cloth, const std::vector<Index>& cloth_ids,
                        const Mesh* obstacle, const std::vector<Index>& obstacle_ids,
                        const ValidatorOptions& options, FrameVerdict& verdict) {
  const auto take = [&](const PairCollector& found, std::int64_t& count) {
    count = found.count();
    verdict.pairs.insert(verdict.pairs.end(), found.pairs().begin(), found.pairs().end());
  };
  if (options.self) take(cloth_pairs(cloth, cloth_ids, options), verdict.cloth_cloth_count);
  if (options.obstacle && obstacle)
    take(obstacle_pairs(cloth, cloth_ids, *obstacle, obstacle_ids, options),
         verdict.cloth_obstacle_count);
}

}  // namespace weft::lab
