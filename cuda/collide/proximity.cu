#include "weft/kernels/collide/proximity.hpp"

#include "cuda/collide/marks.cuh"

namespace weft {
namespace {

constexpr int measure_threads = 256;
constexpr int role_threads = 128;

/// What the stages hand on: pairs that may be contacts, and which of these are.
struct ProximityWork {
  Marks near;      ///< of the pairs, see cuda::PairItems
  Marks contacts;  ///< of the near pairs, in their order
};

template <class T>
__device__ cuda::PairItems items_of(const CollideProximity<T>& a) {
  return {has_all_pairs(a) ? a.counts.data()[0] : CollideCounts{}, a.face_pairs.size(),
          a.edge_pairs.size()};
}

/// Writes a pair's separation bound as if it were no contact. @return whether it may be one
template <int First, class T>
__device__ bool measure(const ProximityRule<T>& rule, std::uint32_t number) {
  PairLanes<T, First, 1> lane;
  rule.add(lane, number);
  T closing[1];
  T reach[1];
  T gap[1];
  rule.look(lane, closing, reach, gap);
  T distance = gap[0];
  bool near = false;
  if (!(gap[0] > reach[0])) {
    distance = rule.template approach<First>(lane.corners(0)).distance;
    near = rule.template is_near<First>(lane.corners(0), distance, closing[0]);
  }
  rule.template separation_bound<First>(number) =
      rule.separation_bound_of(distance, closing[0], lane.size(0));
  return near;
}

template <class T>
__global__ void __launch_bounds__(measure_threads)
    measure_pairs(const __grid_constant__ CollideProximity<T> a, const ProximityWork work) {
  if (blockIdx.x == 0 && threadIdx.x == 0) a.counts.data()[0].slide = 0;
  const ProximityRule<T> rule(a);
  const cuda::PairItems items = items_of(a);
  cuda::mark_items(work.near, items.words, [&](std::uint32_t item) {
    if (!items.is_pair(item)) return false;
    return items.is_face(item) ? measure<1>(rule, items.number(item))
                               : measure<2>(rule, items.number(item));
  });
}

/// Corners of a pair.
template <int First, class T>
__device__ PairRole role(const ProximityRule<T>& rule, std::uint32_t number, Contact<T>& contact) {
  Index v[4];
  rule.template corners<First>(number, v);
  const PairRole role = rule.template role<First>(rule.template pair<First>(number), v,
                                                  rule.template approach<First>(v), contact);
  if (role != PairRole::apart)
    rule.template separation_bound<First>(number) = separation_bound_of_contact;
  return role;
}

/// What the n-th near pair is. Never inlined, so that the pass which writes the contacts decides by
/// the very instructions of the one which counts them.
template <class T>
__device__ __noinline__ PairRole decide(const CollideProximity<T>& a, const ProximityWork& work,
                                        std::uint32_t n, Contact<T>& contact) {
  const ProximityRule<T> rule(a);
  const cuda::PairItems items = items_of(a);
  const std::uint32_t item = nth_mark(work.near, n);
  const std::uint32_t number = items.number(item);
  return items.is_face(item) ? role<1>(rule, number, contact) : role<2>(rule, number, contact);
}

/// Marks the contacts among the near pairs.
template <class T>
__device__ void mark_contacts(const CollideProximity<T>& a, const ProximityWork& work) {
  const std::uint32_t count = work.near.count();
  cuda::mark_items(work.contacts, static_cast<std::uint32_t>(mark_words(count)),
                   [&](std::uint32_t n) {
                     Contact<T> contact;
                     return n < count && decide(a, work, n, contact) == PairRole::contact;
                   });
}

template <class T>
__device__ void write_contacts(const CollideProximity<T>& a, const ProximityWork& work) {
  const std::uint32_t count = work.contacts.count();
  const std::uint32_t first = blockIdx.x * blockDim.x + threadIdx.x;
  float slide = 0;
  for (std::uint32_t n = first; n < count && n < a.contacts.size(); n += gridDim.x * blockDim.x) {
    Contact<T> contact;
    const std::uint32_t near = nth_mark(work.contacts, n);
    decide(a, work, near, contact);
    a.contacts.data()[n] = contact;
    const bool face = items_of(a).is_face(nth_mark(work.near, near));
    const ProximityRule<T> rule(a);
    slide = fmaxf(slide, face ? rule.template slide<1>(contact) : rule.template slide<2>(contact));
  }
  // The bits of floats that are not negative are in the order of their values.
  if (slide > 0)
    atomicMax(reinterpret_cast<int*>(&a.counts.data()[0].slide), __float_as_int(slide));
  if (first != 0) return;
  const std::uint32_t near_faces =
      marks_before(work.near, items_of(a).face_words * Marks::word_items);
  a.counts.data()[0].face_contacts = static_cast<Index>(marks_before(work.contacts, near_faces));
  a.counts.data()[0].contacts = static_cast<Index>(count);
}

/// @param write the contacts; else marks them
template <class T>
__global__ void __launch_bounds__(role_threads)
    decide_contacts(const __grid_constant__ CollideProximity<T> a, const ProximityWork work,
                    bool write) {
  if (write)
    write_contacts(a, work);
  else
    mark_contacts(a, work);
}

}  // namespace

/// Measures all pairs; those that may be contacts are then looked at by threads of their own, and
/// once more to write those that are where they belong. No list but that of the contacts.
template <class T>
void run(OnCuda, Queue& queue, const CollideProximity<T>& args) {
  const auto& cuda_queue = static_cast<const CudaQueue&>(queue);
  cuda_queue.make_current();
  const cudaStream_t stream = cuda_queue.stream();
  const std::size_t faces = args.face_pairs.size();
  const std::size_t edges = args.edge_pairs.size();
  Marks marks[2];
  cuda::take_pair_marks(cuda_queue, args.scratch, proximity_scratch_size(faces, edges),
                        faces + edges, {marks, 2});
  const ProximityWork work{marks[0], marks[1]};
  measure_pairs<<<cuda::resident_blocks, measure_threads, 0, stream>>>(args, work);
  cuda::check(cudaGetLastError(), "kernel launch", cuda_queue.rank());
  cuda::count_marks(cuda_queue, work.near);
  decide_contacts<<<cuda::resident_blocks, role_threads, 0, stream>>>(args, work, false);
  cuda::check(cudaGetLastError(), "kernel launch", cuda_queue.rank());
  cuda::count_marks(cuda_queue, work.contacts);
  decide_contacts<<<cuda::resident_blocks, role_threads, 0, stream>>>(args, work, true);
  cuda::check(cudaGetLastError(), "kernel launch", cuda_queue.rank());
}

template void run(OnCuda, Queue&, const CollideProximity<float>&);
template void run(OnCuda, Queue&, const CollideProximity<double>&);

}  // namespace weft
