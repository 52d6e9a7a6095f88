#include "weft/kernels/collide/pairs.hpp"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

#include "host/collide/grid_walk.hpp"
#include "host/exec/host_device.hpp"
#include "weft/error.hpp"

namespace weft {
namespace {

static_assert(std::endian::native == std::endian::little);  // bytes of bits are read eight at once

/// Eight numbers side by side, in vector registers where there are any.
template <class T>
using Eight [[gnu::vector_size(cluster_size * sizeof(T))]] = T;
/// What comparing Eight<T> gives: all bits set where it holds.
template <class T>
using Mask = Eight<std::conditional_t<std::is_same_v<T, float>, std::int32_t, std::int64_t>>;

template <class T>
const Eight<T>& eight(const T (&numbers)[cluster_size]) {
  return reinterpret_cast<const Eight<T>&>(numbers);
}

/// Sets out[k] to all ones where `a` meets box k of `b`, else to zero.
template <class T>
void compare(const BoxOf<T>& a, const Cluster<T>& b, Mask<T>& out) {
  out = (a.lo[0] <= eight<T>(b.hi[0])) & (eight<T>(b.lo[0]) <= a.hi[0]) &
        (a.lo[1] <= eight<T>(b.hi[1])) & (eight<T>(b.lo[1]) <= a.hi[1]) &
        (a.lo[2] <= eight<T>(b.hi[2])) & (eight<T>(b.lo[2]) <= a.hi[2]);
}

/// The same comparison for boxes that move.
template <class T>
void compare(const SplitBox<T>& a, const Cluster<T>& b, const Cluster<T>& b_ends, Mask<T>& out) {
  out = ~Mask<T>{};
  for (int c = 0; c < 3; ++c)
    out &= ((a.start.lo[c] <= eight<T>(b.hi[c])) | (a.end.lo[c] <= eight<T>(b_ends.hi[c]))) &
           ((eight<T>(b.lo[c]) <= a.start.hi[c]) | (eight<T>(b_ends.lo[c]) <= a.end.hi[c]));
}

template <class T>
std::uint32_t any_of(const Mask<T>& bits) {
  std::uint32_t all = 0;
  for (Index k = 0; k < cluster_size; ++k) all |= static_cast<std::uint32_t>(bits[k]);
  return all;
}

/// Bit k: what `compare_with` sets in `out` for box k.
template <class T, class CompareWith>
std::uint32_t meeting_lanes(CompareWith compare_with) {
  constexpr Mask<T> bit{1, 2, 4, 8, 16, 32, 64, 128};
  Mask<T> meets;
  compare_with(meets);
  return any_of<T>(meets & bit);
}

/// Bit 8 j + k: what `compare_with` sets for box j of one cluster and box k of the other.
template <class T, class CompareWith>
std::uint64_t meeting_matrix(CompareWith compare_with) {
  constexpr Mask<T> bit{1, 2, 4, 8, 16, 32, 64, 128};
  std::uint64_t matrix = 0;
  for (Index half = 0; half < 2; ++half) {
    // Four rows to a number; the columns stay apart until the end.
    Mask<T> bits{};
    for (Index j = 0; j < 4; ++j) {
      Mask<T> meets;
      compare_with(4 * half + j, meets);
      bits |= meets & (bit << 8 * j);
    }
    matrix |= static_cast<std::uint64_t>(any_of<T>(bits)) << 32 * half;
  }
  return matrix;
}

/// Appends to an array of fixed capacity, and counts what does not fit.
class Appender {
 public:
  explicit Appender(Span<Pair> out) : out_(out) {}
  /// @param wanted whether the pair is one; without a branch, because that is anyone's guess
  void add(Index a, Index b, bool wanted) {
    if (count_ < out_.size()) out_.data()[count_] = {a, b};
    count_ += static_cast<std::size_t>(wanted);
  }
  Index count() const {
    if (count_ > static_cast<std::size_t>(std::numeric_limits<Index>::max()))
      throw DeviceError("more pairs than an index can number: " + std::to_string(count_));
    return static_cast<Index>(count_);
  }

 private:
  Span<Pair> out_;
  std::size_t count_ = 0;
};

/// Bits above the diagonal: within one cluster each pair is met once.
constexpr std::uint64_t later_only = 0x0080c0e0f0f8fcfe;

/// Clusters that meet an asking cluster, and which of their boxes meet which of its own.
class MeetingTable {
 public:
  void clear() { first_.clear(); }
  /// @param first number of the cluster's first box
  void add(Index first, std::uint64_t matrix) {
    const std::size_t place = first_.size();
    first_.push_back(first);
    if (bits_.size() < cluster_size * (place / 8 + 1)) bits_.resize(bits_.size() + cluster_size);
    // A number for each asking box and eight clusters, a byte of it for each cluster.
    for (std::size_t j = 0; j < cluster_size; ++j) {
      std::uint64_t& word = bits_[cluster_size * (place / 8) + j];
      const std::uint64_t byte = (matrix >> 8 * j & 255u) << 8 * (place % 8);
      word = place % 8 == 0 ? byte : word | byte;
    }
  }

  /// Calls visit(number) for each box that box j of the asking cluster meets, in ascending order if
  /// the clusters were added so.
  template <class Visit>
  void for_each(Index j, Visit visit) const {
    for (std::size_t w = 0; 8 * w < first_.size(); ++w)
      for (std::uint64_t bits = bits_[cluster_size * w + static_cast<std::size_t>(j)]; bits != 0;
           bits &= bits - 1) {
        const auto bit = static_cast<std::size_t>(std::countr_zero(bits));
        visit(first_[8 * w + bit / 8] + static_cast<Index>(bit % 8));
      }
  }

 private:
  std::vector<Index> first_;
  std::vector<std::uint64_t> bits_;
};

template <class T>
class PairFinder {
 public:
  explicit PairFinder(const CollidePairs<T>& args)
      : a_(args),
        split_(!args.split.empty() && args.split.data()[0] != 0),
        face_pairs_(args.face_pairs),
        edge_pairs_(args.edge_pairs) {}

  void find() {
    const Index cloth = a_.lists[cloth_vertices].group_count();
    for_each_asking(a_.face_work, a_.face_share, [&](Index g) {
      g < cloth ? ask_faces(cloth_vertices, g) : ask_faces(obstacle_vertices, g - cloth);
    });
    for_each_asking(a_.edge_work, a_.edge_share, [&](Index g) { ask_edges(g); });
    CollideCounts counts{};
    counts.face_pairs = face_pairs_.count();
    counts.edge_pairs = edge_pairs_.count();
    counts.tests = tests_;
    a_.counts[0] = counts;
  }

 private:
  /// Calls ask(g) for each group of this rank's share.
  template <class Ask>
  static void for_each_asking(Span<const Offset> work, const WorkShare& share, Ask ask) {
    const Index end = share_begin(work, share.end);
    for (Index g = share_begin(work, share.begin); g < end; ++g) ask(g);
  }

  /// Groups of `kind` that the hull `box` meets, in ascending order: pairs then come in an order
  /// that knows nothing of the grids, so that it does not matter when they were searched.
  void collect_groups(ClusterKind kind, const Box& box, Index lowest, std::vector<Index>& out) {
    out.clear();
    for_each_meeting(a_.grids[kind], a_.lists[kind].hulls, box, lowest,
                     [&](Index number) { out.push_back(number); });
    std::sort(out.begin(), out.end());
  }

  /// What the asking cluster k of list `asking` meets in the groups.
  /// @param lowest asking from the same list: k, so that each pair is met once; else 0
  void meet(ClusterKind kind, const std::vector<Index>& groups, ClusterKind asking, Index k,
            Index lowest, MeetingTable& out) {
    out.clear();
    const ClusterList<T>& list = a_.lists[kind];
    for (const Index g : groups) {
      tests_ += cluster_size;
      for (std::uint32_t bits = clusters_met(list, g, a_.lists[asking], k); bits != 0;
           bits &= bits - 1) {
        const Index cluster = g * cluster_size + static_cast<Index>(std::countr_zero(bits));
        if (cluster < lowest) continue;
        tests_ += cluster_size * cluster_size;
        std::uint64_t matrix = boxes_met(list, cluster, a_.lists[asking], k);
        if (kind == asking && cluster == k) matrix &= later_only;
        if (matrix != 0) out.add(list.first + cluster * cluster_size, matrix);
      }
    }
  }

  /// Bit j: the asking cluster k meets cluster j of group g.
  std::uint32_t clusters_met(const ClusterList<T>& list, Index g, const ClusterList<T>& asking,
                             Index k) const {
    const Cluster<float>& group = list.groups.data()[g];
    const Box start = lane_of<float>(asking.groups.data()[k / cluster_size], k % cluster_size);
    if (!split_) return meeting_lanes<float>([&](Mask<float>& out) { compare(start, group, out); });
    const SplitBox<float> whole{
        start, lane_of<float>(asking.group_ends.data()[k / cluster_size], k % cluster_size)};
    const Cluster<float>& group_ends = list.group_ends.data()[g];
    return meeting_lanes<float>([&](Mask<float>& out) { compare(whole, group, group_ends, out); });
  }

  /// Bit 8 i + j: box i of the asking cluster k meets box j of `cluster`.
  std::uint64_t boxes_met(const ClusterList<T>& list, Index cluster, const ClusterList<T>& asking,
                          Index k) const {
    const Cluster<T>& boxes = asking.clusters.data()[k];
    const Cluster<T>& others = list.clusters.data()[cluster];
    if (!split_)
      return meeting_matrix<T>(
          [&](Index j, Mask<T>& out) { compare(lane_of<T>(boxes, j), others, out); });
    const Cluster<T>& ends = asking.ends.data()[k];
    const Cluster<T>& other_ends = list.ends.data()[cluster];
    return meeting_matrix<T>([&](Index j, Mask<T>& out) {
      compare(SplitBox<T>{lane_of<T>(boxes, j), lane_of<T>(ends, j)}, others, other_ends, out);
    });
  }

  /// Calls ask(k) for each cluster of group g.
  template <class Ask>
  void for_each_cluster(ClusterKind kind, Index g, Ask ask) {
    const Index end = std::min((g + 1) * cluster_size, a_.lists[kind].size());
    for (Index k = g * cluster_size; k < end; ++k) ask(k);
  }

  /// Calls ask(number, j) for each primitive j of cluster k.
  template <class Ask>
  void for_each_primitive(ClusterKind kind, Index k, Ask ask) {
    const ClusterList<T>& list = a_.lists[kind];
    const Index end = std::min(cluster_size, list.count - k * cluster_size);
    for (Index j = 0; j < end; ++j) ask(list.first + k * cluster_size + j, j);
  }

  void ask_faces(ClusterKind kind, Index g) {
    const bool cloth = kind == cloth_vertices;
    const Box& hull = a_.lists[kind].hulls.data()[g];
    groups_cloth_.clear();
    groups_obstacle_.clear();
    if (!cloth || a_.self) collect_groups(cloth_faces, hull, 0, groups_cloth_);
    if (cloth) collect_groups(obstacle_faces, hull, 0, groups_obstacle_);
    for_each_cluster(kind, g, [&](Index k) {
      meet(cloth_faces, groups_cloth_, kind, k, 0, cloth_);
      meet(obstacle_faces, groups_obstacle_, kind, k, 0, obstacle_);
      for_each_primitive(kind, k, [&](Index v, Index j) {
        cloth_.for_each(j, [&](Index f) {
          face_pairs_.add(v, f, shares_no_vertex(v, a_.triangles.data()[f]));
        });
        obstacle_.for_each(j, [&](Index f) { face_pairs_.add(v, f, true); });
      });
    });
  }

  void ask_edges(Index g) {
    const Box& hull = a_.lists[cloth_edges].hulls.data()[g];
    groups_cloth_.clear();
    if (a_.self) collect_groups(cloth_edges, hull, g, groups_cloth_);
    collect_groups(obstacle_edges, hull, 0, groups_obstacle_);
    for_each_cluster(cloth_edges, g, [&](Index k) {
      meet(cloth_edges, groups_cloth_, cloth_edges, k, k, cloth_);
      meet(obstacle_edges, groups_obstacle_, cloth_edges, k, 0, obstacle_);
      for_each_primitive(cloth_edges, k, [&](Index e, Index j) {
        const Edge p = a_.edges.data()[e];
        cloth_.for_each(
            j, [&](Index f) { edge_pairs_.add(e, f, shares_no_vertex(p, a_.edges.data()[f])); });
        obstacle_.for_each(j, [&](Index f) { edge_pairs_.add(e, f, true); });
      });
    });
  }

  const CollidePairs<T> a_;
  const bool split_;
  Appender face_pairs_;
  Appender edge_pairs_;
  Offset tests_ = 0;
  std::vector<Index> groups_cloth_;
  std::vector<Index> groups_obstacle_;
  MeetingTable cloth_;
  MeetingTable obstacle_;
};

}  // namespace

template <class T>
void run(OnHost, Queue& queue, const CollidePairs<T>& args) {
  submit_host(queue, [args] { PairFinder<T>(args).find(); });
}

template void run(OnHost, Queue&, const CollidePairs<float>&);
template void run(OnHost, Queue&, const CollidePairs<double>&);

}  // namespace weft
