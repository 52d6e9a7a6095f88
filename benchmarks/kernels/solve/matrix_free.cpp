// The product of conjugate gradients without a matrix (P-Cloth, figure 18) against the assembled
// one: every element's Jacobian is evaluated again, or read as its kernel left it, in each product,
// and multiplies the vector there. Same system: membrane, hinges, masses and, folded, contacts.
// What an iteration does besides the product is the same for all and not in the figures.
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "benchmarks/support/elements.hpp"
#include "benchmarks/support/kernel_bench.hpp"
#include "benchmarks/support/queue_clock.hpp"
#if defined(__CUDACC__)
#include "cuda/solve/contact_operator.cuh"
#include "cuda/solve/product_row.cuh"
#endif

namespace weft::bench {
namespace {

/// w += A u, element by element; w is cleared before.
template <class T>
struct MatrixFree {
  SystemArgs<T> system;
  Span<const Vec3<T>> u;  ///< [rows]
  Span<Vec3<T>> w;        ///< [rows]
};

/// u at the corners.
template <class T>
struct CornerValues {
  Vec3<T> x[4];

  WEFT_HD CornerValues(const MatrixFree<T>& a, const Corners& e) noexcept : x{} {
    for (int j = 0; j < 4; ++j)
      if (e.v[j] >= 0) x[j] = a.u.data()[e.v[j]];
  }
};

/// Adds a sum at each corner to w.
template <class T>
WEFT_HD void scatter(const MatrixFree<T>& a, const Corners& e, const Vec3<T> sum[4]) noexcept {
  for (int i = 0; i < 4; ++i) {
    if (e.v[i] < 0) continue;
    for (int c = 0; c < 3; ++c) add_to(a.w.data()[e.v[i]][c], sum[i][c]);
  }
}

/// For each element: with its Jacobian as it is at the positions.
template <ElementKind kind>
struct MultiplyElement {
  template <class T>
  WEFT_HD void operator()(const MatrixFree<T>& a, Index n) const noexcept {
    const Elements<T> elements(a.system);
    const Corners e = elements.template corners<kind>(n);
    const CornerValues<T> u(a, e);
    Vec3<T> sum[4]{};
    elements.template visit<kind>(
        n, [&](int i, int j, const Mat3<T>& block) { sum[i] += block * u.x[j]; },
        [](int, const Vec3<T>&) {});
    scatter(a, e, sum);
  }
};

/// The same, but triangles and hinges with what their kernels have stored.
template <ElementKind kind>
struct MultiplyStored : MultiplyElement<kind> {};

template <>
struct MultiplyStored<ElementKind::triangle> {
  template <class T>
  WEFT_HD void operator()(const MatrixFree<T>& a, Index n) const noexcept {
    const Corners e = Elements<T>(a.system).template corners<ElementKind::triangle>(n);
    const CornerValues<T> u(a, e);
    const Mat3<T>* k = a.system.membrane.block.data() + 6 * static_cast<std::size_t>(n);
    const Vec3<T> sum[4] = {k[0] * u.x[0] + k[1] * u.x[1] + k[2] * u.x[2],
                            transpose(k[1]) * u.x[0] + k[3] * u.x[1] + k[4] * u.x[2],
                            transpose(k[2]) * u.x[0] + transpose(k[4]) * u.x[1] + k[5] * u.x[2],
                            {}};
    scatter(a, e, sum);
  }
};

template <>
struct MultiplyStored<ElementKind::hinge> {
  template <class T>
  WEFT_HD void operator()(const MatrixFree<T>& a, Index n) const noexcept {
    const Corners e = Elements<T>(a.system).template corners<ElementKind::hinge>(n);
    const CornerValues<T> u(a, e);
    const Vec3<T>* g = a.system.bending.direction.data() + 4 * static_cast<std::size_t>(n);
    T turn = T(0);
    for (int j = 0; j < 4; ++j) turn += dot(g[j], u.x[j]);
    turn *= a.system.bending.curvature.data()[n];
    Vec3<T> sum[4];
    for (int j = 0; j < 4; ++j) sum[j] = turn * g[j];
    scatter(a, e, sum);
  }
};

/// The assembled system and the vectors of its product.
template <class T>
SolvePcgPart<T> assembled(const SystemArgs<T>& system, const Buffer<Vec3<T>>& u,
                          const Buffer<Vec3<T>>& w, const Buffer<ContactGather<T>>& pull) {
  SolvePcgPart<T> part{};
  const BlockEllOut<T>& m = system.rows.matrix;
  part.mesh = {m.row_count, m.slice, m.slice_offset, m.column, m.value, m.diagonal};
  part.vertex = {system.rows.vertex_mass, system.rows.vertex_drag};
  const AssembleContacts<T>& c = system.contacts;
  if (c.row_count > 0)
    part.contact = {c.link, c.contact_entry_count, c.row_entry_count, c.contact_scatter,
                    pull.span()};
  part.u = u.span();
  part.w = w.span();
  return part;
}

template <class T>
WEFT_HD Vec3<T> plain_row(const BlockEll<T>& m, Index row, const Vec3<T>* u) noexcept {
  Vec3<T> sum{};
  if (m.row_count == 0) return sum;
  const Offset* offset = m.slice_offset.data() + row / m.slice;
  for (Offset slot = offset[0]; slot < offset[1]; ++slot) {
    const Vec3<T>& x = u[m.column.data()[slot * m.slice + row % m.slice]];
    const T* value = m.value.data() + slot * 9 * m.slice + row % m.slice;
    for (int k = 0; k < 9; ++k) sum[k / 3] += value[k * m.slice] * x[k % 3];
  }
  return sum;
}

/// The same of the contact part; each end recomputes the pull of its link.
template <class T>
WEFT_HD Vec3<T> plain_row(const ContactOperator<T>& links, Index row, const Vec3<T>* u) noexcept {
  Vec3<T> sum{};
  if (links.count.empty()) return sum;
  for (Index e = links.end_offset.data()[row]; e < links.end_offset.data()[row + 1]; ++e) {
    const ContactScatter<T>& end = links.end.data()[e];
    const ContactOperatorEntry<T>& link = links.link.data()[end.link];
    Vec3<T> d{};
    for (int j = 0; j < 4; ++j) d += link.w[j] * u[link.v[j]];
    for (int k = 0; k < 9; ++k) sum[k / 3] += end.weight * link.component(k) * d[k % 3];
  }
  return sum;
}

struct MultiplyRow {
  template <class T>
  WEFT_HD void operator()(const SolvePcgPart<T>& part, Index row) const noexcept {
    part.w.data()[row] = part.mesh.diagonal.data()[row] * part.u.data()[row] +
                         plain_row(part.mesh, row, part.u.data()) +
                         plain_row(part.contact, row, part.u.data());
  }
};

#if defined(__CUDACC__)
constexpr int product_threads = 256;

/// The product as the engine's solver has it, in two kernels.
template <class T>
__global__ void __launch_bounds__(product_threads)
    gather_contacts(const __grid_constant__ ContactOperator<T> links, const Vec3<T>* u) {
  cuda::gather_contacts(links, static_cast<int>(blockIdx.x), static_cast<int>(gridDim.x), u);
}
template <class T>
__global__ void __launch_bounds__(product_threads)
    multiply_rows(const __grid_constant__ SolvePcgPart<T> part) {
  const Index row = static_cast<Index>(blockIdx.x * product_threads + threadIdx.x);
  if (row >= part.mesh.row_count) return;
  Vec3<T> sum = cuda::mesh_row<cuda_slice>(part, row, part.u.data(), part.u.data()[row]);
  if (!part.contact.count.empty()) sum += cuda::contact_row<true>(part.contact, row, part.u.data());
  part.w.data()[row] = sum;
}
#endif

template <class T>
void multiply_assembled(Queue& queue, const SolvePcgPart<T>& part) {
#if defined(__CUDACC__)
  if (queue.backend() == Backend::cuda) {
    const auto& cuda_queue = static_cast<const CudaQueue&>(queue);
    cuda_queue.make_current();
    const auto blocks =
        static_cast<unsigned>((part.mesh.row_count + product_threads - 1) / product_threads);
    if (!part.contact.count.empty())
      gather_contacts<<<blocks, product_threads, 0, cuda_queue.stream()>>>(part.contact,
                                                                           part.u.data());
    multiply_rows<<<blocks, product_threads, 0, cuda_queue.stream()>>>(part);
    cuda::check(cudaGetLastError(), "kernel launch", cuda_queue.rank());
    return;
  }
#endif
  for_each(queue, part, part.mesh.row_count, MultiplyRow{});
}

/// Largest difference of components over the largest component.
template <class T>
double difference(const std::vector<Vec3<T>>& a, const std::vector<Vec3<T>>& b) {
  double most = 0, apart = 0;
  for (std::size_t n = 0; n < a.size(); ++n)
    for (int c = 0; c < 3; ++c) {
      most = std::max(most, std::abs(double(a[n][c])));
      apart = std::max(apart, std::abs(double(a[n][c]) - double(b[n][c])));
    }
  return apart / most;
}

/// Seconds of each way.
struct Times {
  double assemble = 0;        ///< whole system
  double elements = 0;        ///< the kernels of triangles and hinges alone
  double product = 0;         ///< assembled
  double product_free = 0;    ///< with Jacobians evaluated
  double product_stored = 0;  ///< with stored ones
};

/// What a solve of so many iterations takes with each way, products and what goes before them.
Json solve_times(const Times& t) {
  Json list('[');
  for (const double iterations : {1, 3, 10, 30, 100, 300, 1000}) {
    Json at;
    at.add("iterations", iterations)
        .add("assembled_us", 1e6 * (t.assemble + iterations * t.product));
    at.add("matrix_free_us", 1e6 * iterations * t.product_free);
    at.add("stored_elements_us", 1e6 * (t.elements + iterations * t.product_stored));
    list.add(at);
  }
  return list;
}

/// Iterations from which on a solve with the matrix is faster; 0 if it never is.
double break_even(double before, double product, double other_before, double other_product) {
  if (!(other_product > product)) return 0;
  return std::max(0.0, (before - other_before) / (other_product - product));
}

/// @throws std::runtime_error if the products do not agree
template <class T>
Json measure(const Options& options, int vertices, bool folded) {
  const auto cells = static_cast<Index>(std::lround(std::sqrt(double(vertices)))) - 1;
  Scene scene = wavy_sheet(cells);
  scene.bending = Bending::hinge;
  FirstSystem<T> first(scene, parse_devices(options.device), folded);
  const SystemArgs<T> system = assemble_and_catch(first);
  Device& device = first.device();
  Queue& queue = device.compute();
  const auto rows = static_cast<std::size_t>(system.rows.matrix.row_count);
  std::vector<Vec3<T>> start(rows);
  for (std::size_t n = 0; n < rows; ++n)
    start[n] = {static_cast<T>(std::sin(0.37 * double(n))),
                static_cast<T>(std::cos(0.11 * double(n))),
                static_cast<T>(std::sin(0.05 * double(n) + 1))};
  Buffer<Vec3<T>> u(device), w(device, rows);
  upload(queue, u, start);
  const Buffer<ContactGather<T>> pull(device, system.contacts.link.size());
  const SolvePcgPart<T> part = assembled(system, u, w, pull);
  const MatrixFree<T> free{system, u.span(), w.span()};
  const auto clear = [&] { queue.fill(w.data(), 0, rows * sizeof(Vec3<T>)); };
  const int repeats = options.smoke ? 1 : 20;
  Times t;
  t.assemble = median_time(queue, repeats, [&] { assemble_again(queue, system); });
  t.elements = median_time(queue, repeats, [&] {
    launch_unobserved(queue, system.membrane);
    launch_unobserved(queue, system.bending);
  });
  t.product = median_time(queue, repeats, [&] { multiply_assembled(queue, part); });
  const std::vector<Vec3<T>> right = download(queue, w);
  t.product_free = median_time(queue, repeats, [&] {
    clear();
    for_each_element<MultiplyElement>(queue, free);
  });
  const double error_free = difference(right, download(queue, w));
  t.product_stored = median_time(queue, repeats, [&] {
    clear();
    for_each_element<MultiplyStored>(queue, free);
  });
  const double error_stored = difference(right, download(queue, w));
  Json result;
  result.add("vertices", static_cast<double>(rows));
  result.add("triangles", static_cast<double>(system.membrane.triangles.size()));
  result.add("hinges", static_cast<double>(system.bending.hinges.size()));
  result.add("contacts", static_cast<double>(system.contacts.contacts.size()));
  result.add("precision", sizeof(T) == 4 ? "float" : "double");
  result.add("assemble_us", 1e6 * t.assemble).add("elements_us", 1e6 * t.elements);
  result.add("product_us", 1e6 * t.product).add("matrix_free_product_us", 1e6 * t.product_free);
  result.add("stored_elements_product_us", 1e6 * t.product_stored);
  result.add("difference", error_free).add("difference_stored", error_stored);
  result.add("assembled_wins_from_iterations",
             break_even(t.assemble, t.product, 0, t.product_free));
  result.add("assembled_wins_over_stored_from_iterations",
             break_even(t.assemble, t.product, t.elements, t.product_stored));
  result.add("solves", solve_times(t));
  std::cout << result.text() << std::endl;
  // Sums of some dozens of products, each way rounded in another order.
  const double bound = 64 * (sizeof(T) == sizeof(float) ? 0x1p-23 : 0x1p-52);
  if (!(error_free < bound) || !(error_stored < bound))
    throw std::runtime_error("the products without a matrix are not that with it");
  return result;
}

void measure_all(const Options& options) {
  Json results('[');
  for (const int vertices : options.vertices)
    for (const bool folded : {false, true}) {
      results.add(measure<float>(options, vertices, folded));
      if (options.smoke) results.add(measure<double>(options, vertices, folded));
    }
  write(options, "matrix_free", results);
}

}  // namespace
}  // namespace weft::bench

int main(int argc, char** argv) {
  return weft::bench::run(argc, argv, weft::bench::measure_all);
}
