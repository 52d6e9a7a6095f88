#include "weft/kernels/assemble/rest_shape_rows.hpp"

#include "tests/parity/support.hpp"

namespace weft::parity {
namespace {

/// 300 rows, each with up to six forces and up to three corners of 200 triangles.
template <class T>
struct RestShapeRowsCase {
  using Scalar = T;
  static constexpr Index row_count = 300, triangles = 200, forces = 900;
  Random random{41};
  std::vector<Offset> entry_offset{0}, corner_offset{0};
  std::vector<Index> entry, entry_triangle, corner;
  std::vector<Vec3<T>> force = random.vectors<T>(forces, -1, 1);
  std::vector<Vec3<T>> axes = random.vectors<T>(3 * triangles, -1, 1);
  std::vector<Vec3<T>> corner_force = random.vectors<T>(3 * triangles, -1, 1);
  std::vector<Vec3<T>> rhs = random.vectors<T>(row_count, -1e-2, 1e-2);
  T h = T(0.0078125);

  RestShapeRowsCase() {
    for (Index e = 0; e < forces; ++e) entry_triangle.push_back(below(triangles));
    for (Index r = 0; r < row_count; ++r) {
      for (Index k = 0; k < r % 7; ++k) entry.push_back(below(forces));
      for (Index k = 0; k < r % 4; ++k) corner.push_back(below(3 * triangles));
      entry_offset.push_back(static_cast<Offset>(entry.size()));
      corner_offset.push_back(static_cast<Offset>(corner.size()));
    }
  }
  Index below(Index bound) {
    return static_cast<Index>(random.uniform<double>(0, 1) * (bound - 1));
  }

  Outputs compute(Device& device, Index parts) const {
    const auto entry_offset_d = upload(device, entry_offset),
               corner_offset_d = upload(device, corner_offset);
    const auto entry_d = upload(device, entry), entry_triangle_d = upload(device, entry_triangle),
               corner_d = upload(device, corner);
    const auto force_d = upload(device, force), axes_d = upload(device, axes),
               corner_force_d = upload(device, corner_force), rhs_d = upload(device, rhs);
    for (const auto& [begin, size] : parts_of(row_count, parts)) {
      const auto b = static_cast<std::size_t>(begin), n = static_cast<std::size_t>(size);
      launch(device.compute(),
             AssembleRestShapeRows<T>{size, entry_offset_d.span().subspan(b, n + 1), entry_d.span(),
                                      entry_triangle_d.span(), force_d.span(),
                                      corner_offset_d.span().subspan(b, n + 1), corner_d.span(),
                                      axes_d.span(), corner_force_d.span(), h,
                                      rhs_d.span().subspan(b, n)});
    }
    return {output("rhs", download(rhs_d))};
  }

  Outputs reference() const {
    std::vector<Vec3<double>> sums;
    for (std::size_t r = 0; r < rhs.size(); ++r) {
      Vec3<double> sum{};
      for (auto n = static_cast<std::size_t>(entry_offset[r]);
           n < static_cast<std::size_t>(entry_offset[r + 1]); ++n) {
        const auto e = static_cast<std::size_t>(entry[n]);
        for (int c = 0; c < 3; ++c)
          sum += double{force[e][c]} *
                 vec_cast<double>(axes[3 * static_cast<std::size_t>(entry_triangle[e]) +
                                       static_cast<std::size_t>(c)]);
      }
      for (auto n = static_cast<std::size_t>(corner_offset[r]);
           n < static_cast<std::size_t>(corner_offset[r + 1]); ++n)
        sum += vec_cast<double>(corner_force[static_cast<std::size_t>(corner[n])]);
      sums.push_back(vec_cast<double>(rhs[r]) + double{h} * sum);
    }
    return {output("rhs", sums)};
  }
};

using Cases = testing::Types<RestShapeRowsCase<float>, RestShapeRowsCase<double>>;
INSTANTIATE_TYPED_TEST_SUITE_P(AssembleRestShapeRows, KernelParity, Cases);

}  // namespace
}  // namespace weft::parity
