#include "weft/kernels/solve/schwarz_level.hpp"

#include "cuda/exec/launch.cuh"
#include "cuda/exec/sums.cuh"

namespace weft {
namespace {

/// Pairs of aggregates, each of which some threads sum: they take equal parts of the rows.
constexpr int side = static_cast<int>(schwarz_aggregates_max);
constexpr int size_max = 3 * side;
constexpr Index domain_rows_max = schwarz_aggregates_max << schwarz_shift(schwarz_level_count - 1);

struct Domain {
  double pivot_row[2][size_max];
  double pivot_column[2][size_max];
  unsigned char fixed[domain_rows_max];
};

/// What a thread holds of a domain: rows [begin, end) of it for the block of aggregates (i, j).
struct Piece {
  int i, j;
  Index first, last;  ///< rows of the domain
  Index begin, end;   ///< of the thread, counted from `first`
  Index target;       ///< first row of aggregate j
  Index width;        ///< its rows

  /// Whether a row is a free one of aggregate j.
  __device__ bool has(Index row, const Domain& domain) const {
    return row >= target && row < target + width && domain.fixed[row - first] == 0;
  }
};

/// Component k, 3 i + j, of one entry's block.
template <class T>
__device__ T component(const BlockEll<T>& m, Offset slot, Index lane, int k) {
  return m.value.data()[(slot * 9 + k) * m.slice + lane];
}
template <class T>
__device__ T component(const ScalarEll<T>& m, Offset slot, Index lane, int k) {
  return k % 4 == 0 ? m.value.data()[slot * m.slice + lane] : T(0);
}

/// Adds a thread's part of the entries of `m`, row by row.
template <class T, class Matrix>
__device__ void add_entries(const SolveSchwarzLevel<T>& a, const Matrix& m, const Piece& piece,
                            const Domain& domain, double (&sum)[3][3]) {
  if (m.row_count == 0) return;
  for (Index place = piece.begin; place < piece.end; ++place) {
    if (domain.fixed[place] != 0) continue;
    const Index row = piece.first + place;
    const Index lane = row % m.slice;
    const Offset end = m.slice_offset.data()[row / m.slice + 1];
#pragma unroll 4
    for (Offset slot = m.slice_offset.data()[row / m.slice]; slot < end; ++slot) {
      if (!piece.has(m.column.data()[slot * m.slice + lane] - a.row_begin, domain)) continue;
#pragma unroll
      for (int k = 0; k < 9; ++k)
        sum[k / 3][k % 3] += static_cast<double>(component(m, slot, lane, k));
    }
  }
}

/// The same of the blocks on the mesh's diagonal.
template <class T>
__device__ void add_diagonal(const SolveSchwarzLevel<T>& a, const Piece& piece,
                             const Domain& domain, double (&sum)[3][3]) {
  if (piece.i != piece.j) return;
  for (Index place = piece.begin; place < piece.end; ++place) {
    if (domain.fixed[place] != 0) continue;
    const Mat3<T>& block = a.mesh.diagonal.data()[piece.first + place];
#pragma unroll
    for (int k = 0; k < 9; ++k) sum[k / 3][k % 3] += static_cast<double>(block.e[k]);
  }
}

/// The same of links.
template <class T>
__device__ void add_entries(const SolveSchwarzLevel<T>& a, const ContactOperator<T>& links,
                            const Piece& piece, const Domain& domain, double (&sum)[3][3]) {
  if (links.count.empty()) return;
  for (Index place = piece.begin; place < piece.end; ++place) {
    if (domain.fixed[place] != 0) continue;
    visit_contact_entries(links, piece.first + place,
                          [&](Index column, T weight, const ContactOperatorEntry<T>& link) {
                            if (!piece.has(column - a.row_begin, domain)) return;
#pragma unroll
                            for (int k = 0; k < 9; ++k)
                              sum[k / 3][k % 3] += static_cast<double>(weight * link.component(k));
                          });
  }
}

/// Inverts a symmetric positive definite matrix in place (Gauss-Jordan, which needs no pivots
/// there), of which each thread holds a block. Row and column of the pivot go round by shared
/// memory, two sets by turns.
__device__ void invert(Domain& domain, int aggregates, const Piece& piece, double (&m)[3][3]) {
  for (int block = 0; block < aggregates; ++block)
#pragma unroll
    for (int c = 0; c < 3; ++c) {
      double* row = domain.pivot_row[(block + c) % 2];
      double* column = domain.pivot_column[(block + c) % 2];
      for (int k = 0; k < 3; ++k) {
        if (piece.i == block) row[3 * piece.j + k] = m[c][k];
        if (piece.j == block) column[3 * piece.i + k] = m[k][c];
      }
      __syncthreads();
      const double scale = 1 / row[3 * block + c];
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
          const bool in_row = piece.i == block && i == c;
          const bool in_column = piece.j == block && j == c;
          const double scaled = row[3 * piece.j + j] * scale;
          if (in_row)
            m[i][j] = in_column ? scale : scaled;
          else if (in_column)
            m[i][j] = -column[3 * piece.i + i] * scale;
          else
            m[i][j] -= column[3 * piece.i + i] * scaled;
        }
    }
}

/// One block a domain.
/// @tparam parts threads that share the rows of a pair of aggregates, side by side in a warp
template <class T, int parts>
__global__ void __launch_bounds__(side* side* parts)
    solve_schwarz_level(const __grid_constant__ SolveSchwarzLevel<T> a) {
  __shared__ Domain domain;
  constexpr int threads = side * side * parts;
  const auto thread = static_cast<int>(threadIdx.x);
  Piece piece{};
  piece.i = thread / parts / side;
  piece.j = thread / parts % side;
  piece.first = static_cast<Index>(blockIdx.x) * a.level.domain_rows();
  piece.last = min(a.mesh.row_count, piece.first + a.level.domain_rows());
  for (Index row = piece.first + thread; row < piece.last; row += threads)
    domain.fixed[row - piece.first] = a.fixed.data()[a.row_begin + row];
  const Index share = (Index{1} << a.level.shift) / parts;
  const Index rows = piece.last - piece.first;
  piece.begin = min(rows, (static_cast<Index>(piece.i) << a.level.shift) + thread % parts * share);
  piece.end = min(rows, piece.begin + share);
  piece.target = piece.first + (static_cast<Index>(piece.j) << a.level.shift);
  piece.width = min(Index{1} << a.level.shift, piece.last - piece.target);
  __syncthreads();
  double m[3][3] = {};
  const auto aggregates = static_cast<int>(a.level.aggregates);
  if (piece.i < aggregates && piece.j < aggregates) {
    add_diagonal(a, piece, domain, m);
    add_entries(a, a.mesh, piece, domain, m);
    add_entries(a, a.far, piece, domain, m);
    add_entries(a, a.contact, piece, domain, m);
  }
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      for (int step = 1; step < parts; step *= 2)
        m[i][j] += __shfl_xor_sync(cuda::whole_warp, m[i][j], step);
      if (piece.i == piece.j && i == j && m[i][j] == 0) m[i][j] = 1;
    }
  invert(domain, aggregates, piece, m);
  if (thread % parts != 0 || piece.i < piece.j || piece.i >= aggregates) return;
  // Conjugate gradients need a symmetric preconditioner, to the bit.
  const int size = static_cast<int>(a.level.size());
  T* out = a.level.inverse.data() + static_cast<std::size_t>(blockIdx.x) * size * size;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const int row = 3 * piece.i + i;
      const int column = 3 * piece.j + j;
      if (row < column) continue;
      out[row * size + column] = static_cast<T>(m[i][j]);
      out[column * size + row] = static_cast<T>(m[i][j]);
    }
}

}  // namespace

template <class T>
void run(OnCuda, Queue& queue, const SolveSchwarzLevel<T>& args) {
  const Index rows = args.mesh.row_count;
  if (rows <= 0) return;
  const auto& cuda_queue = static_cast<const CudaQueue&>(queue);
  cuda_queue.make_current();
  const Index step = args.level.domain_rows();
  const auto blocks = static_cast<unsigned>((rows + step - 1) / step);
  // Two rows a thread, or sixteen.
  if (args.level.shift <= schwarz_shift(0))
    solve_schwarz_level<T, 1><<<blocks, side * side, 0, cuda_queue.stream()>>>(args);
  else
    solve_schwarz_level<T, 4><<<blocks, side * side * 4, 0, cuda_queue.stream()>>>(args);
  cuda::check(cudaGetLastError(), "kernel launch", cuda_queue.rank());
}

template void run(OnCuda, Queue&, const SolveSchwarzLevel<float>&);
template void run(OnCuda, Queue&, const SolveSchwarzLevel<double>&);

}  // namespace weft
