#include "weft/kernels/collide/continuous.hpp"

#include "cuda/collide/marks.cuh"

namespace weft {
namespace {

constexpr int vertex_threads = 256;
constexpr int sift_threads = 256;
constexpr int ccd_threads = 64;

/// What the stages hand on, each the marks of those items of the one before that may collide.
struct ContinuousWork {
  Marks loose;       ///< of the pairs, see cuda::PairItems: what separation bounds leave
  Marks close;       ///< of these: what boxes and planes leave
  Marks collisions;  ///< of these
};

template <class T>
__device__ cuda::PairItems items_of(const CollideContinuous<T>& a) {
  return {a.counts.data()[0], a.face_pairs.size(), a.edge_pairs.size()};
}

template <class T>
__global__ void clear_counts(const __grid_constant__ CollideContinuous<T> a) {
  CollideCounts& counts = a.counts.data()[0];
  counts.out_of_bounds = 0;
  counts.not_finite = 0;
  counts.missed = 0;
}

/// Adds up over a block what its threads counted.
__device__ void add_to(Index& sum, int own) {
  own = __reduce_add_sync(cuda::whole_warp, own);
  if (threadIdx.x % Marks::word_items == 0 && own > 0) atomicAdd(&sum, own);
}

template <class T>
__global__ void __launch_bounds__(vertex_threads)
    check_vertices(const __grid_constant__ CollideContinuous<T> a) {
  const ContinuousRule<T> rule(a);
  const std::uint32_t first = blockIdx.x * vertex_threads + threadIdx.x;
  int not_finite = 0;
  int out_of_bounds = 0;
  for (std::uint32_t v = first; v < a.deviation.size(); v += gridDim.x * vertex_threads) {
    a.deviation.data()[v] = rule.deviation(v);
    const auto vertex = static_cast<Index>(v);
    if (vertex < a.vertex_begin || vertex >= a.vertex_end) continue;
    not_finite += rule.not_finite(vertex);
    out_of_bounds += rule.out_of_bounds(vertex) ? 1 : 0;
  }
  add_to(a.counts.data()[0].not_finite, not_finite);
  add_to(a.counts.data()[0].out_of_bounds, out_of_bounds);
}

template <int First, class T>
__device__ bool is_loose(const ContinuousRule<T>& rule, std::uint32_t number) {
  Index v[4];
  rule.template corners<First>(number, v);
  return rule.template has_to_be_looked_at<First>(v, rule.template separation_bound<First>(number));
}

template <class T>
__global__ void __launch_bounds__(sift_threads)
    sift_by_separation_bound(const __grid_constant__ CollideContinuous<T> a,
                             const ContinuousWork work) {
  const ContinuousRule<T> rule(a);
  const cuda::PairItems items = items_of(a);
  cuda::mark_items(work.loose, items.words, [&](std::uint32_t item) {
    if (!items.is_pair(item)) return false;
    return items.is_face(item) ? is_loose<1>(rule, items.number(item))
                               : is_loose<2>(rule, items.number(item));
  });
}

template <int First, class T>
__device__ bool is_close(const CollideContinuous<T>& a, const ContinuousRule<T>& rule,
                         std::uint32_t number) {
  Index v[4];
  rule.template corners<First>(number, v);
  PairLanes<T, First, 1> lane;
  lane.add(v, number, a.positions_t0, a.positions_t1);
  bool close[1];
  rule.may_collide(lane, close);
  return close[0];
}

template <class T>
__global__ void __launch_bounds__(sift_threads)
    sift_by_distance(const __grid_constant__ CollideContinuous<T> a, const ContinuousWork work) {
  const ContinuousRule<T> rule(a);
  const cuda::PairItems items = items_of(a);
  const std::uint32_t count = work.loose.count();
  cuda::mark_items(work.close, static_cast<std::uint32_t>(mark_words(count)), [&](std::uint32_t n) {
    if (n >= count) return false;
    const std::uint32_t item = nth_mark(work.loose, n);
    return items.is_face(item) ? is_close<1>(a, rule, items.number(item))
                               : is_close<2>(a, rule, items.number(item));
  });
}

enum class CcdOutcome { none, expected, missed };

template <int First, class T>
__device__ CcdOutcome detect(const ContinuousRule<T>& rule, std::uint32_t number, Collision& c) {
  Index v[4];
  rule.template corners<First>(number, v);
  if (!rule.template collides<First>(v, c)) return CcdOutcome::none;
  return rule.template separation_bound<First>(number) == separation_bound_of_contact
             ? CcdOutcome::expected
             : CcdOutcome::missed;
}

/// Whether the n-th close pair collides. Never inlined, so that the pass which writes the
/// collisions decides by the very instructions of the one which counts them.
template <class T>
__device__ __noinline__ CcdOutcome detect(const CollideContinuous<T>& a, const ContinuousWork& work,
                                          std::uint32_t n, Collision& c) {
  const ContinuousRule<T> rule(a);
  const cuda::PairItems items = items_of(a);
  const std::uint32_t item = nth_mark(work.loose, nth_mark(work.close, n));
  const std::uint32_t number = items.number(item);
  return items.is_face(item) ? detect<1>(rule, number, c) : detect<2>(rule, number, c);
}

/// Marks the collisions among the close pairs.
template <class T>
__device__ void mark_collisions(const CollideContinuous<T>& a, const ContinuousWork& work) {
  const std::uint32_t count = work.close.count();
  int missed = 0;
  cuda::mark_items(work.collisions, static_cast<std::uint32_t>(mark_words(count)),
                   [&](std::uint32_t n) {
                     if (n >= count) return false;
                     Collision collision;
                     const CcdOutcome outcome = detect(a, work, n, collision);
                     missed += outcome == CcdOutcome::missed ? 1 : 0;
                     return outcome != CcdOutcome::none;
                   });
  add_to(a.counts.data()[0].missed, missed);
}

template <class T>
__device__ void write_collisions(const CollideContinuous<T>& a, const ContinuousWork& work) {
  const std::uint32_t count = work.collisions.count();
  const std::uint32_t first = blockIdx.x * blockDim.x + threadIdx.x;
  for (std::uint32_t n = first; n < count && n < a.collisions.size(); n += gridDim.x * blockDim.x) {
    Collision collision;
    detect(a, work, nth_mark(work.collisions, n), collision);
    a.collisions.data()[n] = collision;
  }
  if (first != 0) return;
  const std::uint32_t loose_faces =
      marks_before(work.loose, items_of(a).face_words * Marks::word_items);
  const std::uint32_t close_faces = marks_before(work.close, loose_faces);
  CollideCounts& counts = a.counts.data()[0];
  counts.face_collisions = static_cast<Index>(marks_before(work.collisions, close_faces));
  counts.collisions = static_cast<Index>(count);
  counts.ccd_tests = static_cast<Offset>(work.close.count());
}

/// @param write the collisions; else marks them
template <class T>
__global__ void __launch_bounds__(ccd_threads)
    detect_collisions(const __grid_constant__ CollideContinuous<T> a, const ContinuousWork work,
                      bool write) {
  if (write)
    write_collisions(a, work);
  else
    mark_collisions(a, work);
}

}  // namespace

/// Each test gets what the cheaper one before it left, packed: threads of a warp do the same work.
/// Collisions are few: they are found once more to be written where they belong.
template <class T>
void run(OnCuda, Queue& queue, const CollideContinuous<T>& args) {
  const auto& cuda_queue = static_cast<const CudaQueue&>(queue);
  cuda_queue.make_current();
  const cudaStream_t stream = cuda_queue.stream();
  const auto check = [&cuda_queue] {
    cuda::check(cudaGetLastError(), "kernel launch", cuda_queue.rank());
  };
  const std::size_t faces = args.face_pairs.size();
  const std::size_t edges = args.edge_pairs.size();
  Marks marks[3];
  cuda::take_pair_marks(cuda_queue, args.scratch, continuous_scratch_size(faces, edges),
                        faces + edges, {marks, 3});
  const ContinuousWork work{marks[0], marks[1], marks[2]};
  clear_counts<<<1, 1, 0, stream>>>(args);
  check();
  check_vertices<<<cuda::resident_blocks, vertex_threads, 0, stream>>>(args);
  check();
  sift_by_separation_bound<<<cuda::resident_blocks, sift_threads, 0, stream>>>(args, work);
  check();
  cuda::count_marks(cuda_queue, work.loose);
  sift_by_distance<<<cuda::resident_blocks, sift_threads, 0, stream>>>(args, work);
  check();
  cuda::count_marks(cuda_queue, work.close);
  detect_collisions<<<cuda::resident_blocks, ccd_threads, 0, stream>>>(args, work, false);
  check();
  cuda::count_marks(cuda_queue, work.collisions);
  detect_collisions<<<cuda::resident_blocks, ccd_threads, 0, stream>>>(args, work, true);
  check();
}

template void run(OnCuda, Queue&, const CollideContinuous<float>&);
template void run(OnCuda, Queue&, const CollideContinuous<double>&);

}  // namespace weft
