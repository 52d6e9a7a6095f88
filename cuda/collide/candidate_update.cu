#include "weft/kernels/collide/candidate_update.hpp"

#include "cuda/collide/clusters.cuh"
#include "cuda/exec/launch.cuh"

namespace weft {
namespace {

constexpr int ask_threads = 256;
constexpr int ask_blocks = 1024;

template <class Item>
__device__ void append(Span<Item> list, Index& count, const Item& item) {
  const Index place = atomicAdd(&count, 1);
  if (static_cast<std::size_t>(place) < list.size()) list.data()[place] = item;
}

struct FindOutOfBounds {
  template <class T>
  __device__ void operator()(const CollideCandidateUpdate<T>& a, Index v) const {
    Index place = -1;
    if (is_out_of_bounds(a, v)) {
      CandidateUpdateCounts& counts = a.counts.data()[0];
      if (v >= a.boxes.cloth_vertex_count) atomicAdd(&counts.obstacles, 1);
      place = atomicAdd(&counts.out_of_bounds, 1);
      if (static_cast<std::size_t>(place) < a.out_of_bounds.size())
        a.out_of_bounds.data()[place].vertex = v;
    }
    a.out_of_bounds_index.data()[v] = place;
  }
};

struct GrowSweptAabb {
  template <class T>
  __device__ void operator()(const CollideCandidateUpdate<T>& a, Index n) const {
    if (may_grow(a) && n < a.counts.data()[0].out_of_bounds) grow_swept_aabb(a, n);
  }
};

struct Touch {
  int kind;
  template <class T>
  __device__ void operator()(const CollideCandidateUpdate<T>& a, Index i) const {
    if (may_grow(a) && is_dirty(a, kind, i))
      append(a.dirty, a.counts.data()[0].dirty, DirtyPrimitive{kind, i});
  }
};

/// A block a dirty primitive, a thread a group.
template <class T>
__global__ void __launch_bounds__(ask_threads)
    ask_dirty(const __grid_constant__ CollideCandidateUpdate<T> a) {
  CandidateUpdateCounts& counts = a.counts.data()[0];
  const Index count = counts.dirty;
  if (!may_grow(a) || static_cast<std::size_t>(count) > a.dirty.size()) return;
  for (auto n = static_cast<Index>(blockIdx.x); n < count; n += static_cast<Index>(gridDim.x)) {
    const DirtyPrimitive dirty = a.dirty.data()[n];
    const GrownBoxes<T> boxes = grown_boxes(a, dirty.kind, dirty.number);
    const int partner = partner_kind(dirty.kind);
    for (int kind = a.self ? partner : partner + 1; kind <= partner + 1; ++kind)
      for (auto g = static_cast<Index>(threadIdx.x); g < a.boxes.lists[kind].group_count();
           g += ask_threads)
        meet_group(a, dirty, boxes, kind, g, [&](const Pair& pair) {
          if (partner == cloth_edges)
            append(a.edge_pairs, counts.edge_pairs, pair);
          else
            append(a.face_pairs, counts.face_pairs, pair);
        });
  }
}

}  // namespace

/// Compiled without fused multiply-add: what a primitive's box was before it has to have the very
/// bits that the search compared.
template <class T>
void run(OnCuda, Queue& queue, const CollideCandidateUpdate<T>& args) {
  queue.fill(args.counts.data(), 0, sizeof(CandidateUpdateCounts));
  launch_for_each(queue, args, static_cast<Index>(args.out_of_bounds_index.size()),
                  FindOutOfBounds{});
  launch_for_each(queue, args, static_cast<Index>(args.out_of_bounds.size()), GrowSweptAabb{});
  for (const int kind : {cloth_vertices, cloth_faces, cloth_edges})
    launch_for_each(queue, args, args.boxes.lists[kind].count, Touch{kind});
  remake_clusters(queue, args.boxes);
  if (!args.search) return;
  const auto& cuda_queue = static_cast<const CudaQueue&>(queue);
  ask_dirty<<<ask_blocks, ask_threads, 0, cuda_queue.stream()>>>(args);
  cuda::check(cudaGetLastError(), "kernel launch", cuda_queue.rank());
}

template void run(OnCuda, Queue&, const CollideCandidateUpdate<float>&);
template void run(OnCuda, Queue&, const CollideCandidateUpdate<double>&);

}  // namespace weft
