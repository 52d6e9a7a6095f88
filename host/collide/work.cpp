#include "weft/kernels/collide/work.hpp"

#include "host/collide/grid_walk.hpp"
#include "host/exec/host_device.hpp"

namespace weft {
namespace {

template <class T>
class WorkCounter {
 public:
  explicit WorkCounter(const CollideWork<T>& args) : a_(args) {}

  void count() const {
    const Index cloth = a_.lists[cloth_vertices].group_count();
    scan(a_.face_work, [&](Index g) {
      if (g >= cloth)
        return tests(cloth_faces, a_.lists[obstacle_vertices].hulls.data()[g - cloth]);
      const Box& box = a_.lists[cloth_vertices].hulls.data()[g];
      return tests(obstacle_faces, box) + (a_.self ? tests(cloth_faces, box) : 0);
    });
    scan(a_.edge_work, [&](Index g) {
      const Box& box = a_.lists[cloth_edges].hulls.data()[g];
      return tests(obstacle_edges, box) + (a_.self ? tests(cloth_edges, box, g) : 0);
    });
  }

 private:
  Offset tests(ClusterKind kind, const Box& box, Index lowest = 0) const {
    return query_tests(a_.grids[kind], a_.lists[kind].hulls.size(), box, lowest);
  }

  /// Every group counts for something, so that a share never ends before the last.
  template <class WorkOf>
  static void scan(Span<Offset> sums, WorkOf work_of) {
    sums[0] = 0;
    for (std::size_t g = 0; g + 1 < sums.size(); ++g)
      sums[g + 1] = sums[g] + 1 + work_of(static_cast<Index>(g));
  }

  const CollideWork<T> a_;
};

}  // namespace

template <class T>
void run(OnHost, Queue& queue, const CollideWork<T>& args) {
  submit_host(queue, [args] { WorkCounter<T>(args).count(); });
}

template void run(OnHost, Queue&, const CollideWork<float>&);
template void run(OnHost, Queue&, const CollideWork<double>&);

}  // namespace weft
