#include "weft/kernels/assemble/plate.hpp"

#include "tests/parity/support.hpp"

namespace weft::parity {
namespace {

constexpr Index slice = 8;

/// Rows 40 to 339 of 400 vertices: near entries in the blocks of a mesh matrix of four slots, far
/// ones in slots of their own, of which every slice has another number.
template <class T, bool with_velocities>
struct PlateCase {
  using Scalar = T;
  static constexpr Index count = 400, row_begin = 40, row_count = 300, mesh_slots = 4;
  static constexpr Index slices = (row_count + slice - 1) / slice;
  Random random{13};
  std::vector<Offset> near_offset{0}, near_place, far_offset{0};
  std::vector<Index> near_column, far_column;
  std::vector<T> near_stiffness, near_damping, far_stiffness, far_damping;
  std::vector<Vec3<T>> positions = random.vectors<T>(count, -1, 1);
  std::vector<Vec3<T>> velocities =
      with_velocities ? random.vectors<T>(count, -1, 1) : std::vector<Vec3<T>>{};
  std::vector<T> mesh_value =
      random.numbers<T>(static_cast<std::size_t>(9 * slices * mesh_slots * slice), -1, 1);
  std::vector<Vec3<T>> rhs = random.vectors<T>(row_count, -1e-2, 1e-2);
  T h = T(0.0078125);

  PlateCase() {
    for (Index r = 0; r < row_count; ++r) {
      for (Index slot = 0; slot < mesh_slots - r % 2; ++slot) {
        near_place.push_back(Offset{(r / slice * mesh_slots + slot) * 9} * slice + r % slice);
        near_column.push_back((row_begin + r + 3 * slot) % count);
        near_stiffness.push_back(random.uniform<T>(-50, 50));
        near_damping.push_back(random.uniform<T>(-0.5, 0.5));
      }
      near_offset.push_back(static_cast<Offset>(near_place.size()));
    }
    for (Index s = 0; s < slices; ++s) {
      for (Index slot = 0; slot < s % 5; ++slot)
        for (Index lane = 0; lane < slice; ++lane) {
          const Index row = std::min(s * slice + lane, row_count - 1);
          const bool padding = (row + slot) % 3 == 0;
          far_column.push_back(padding ? row_begin + row : (row_begin + row + 50 + slot) % count);
          far_stiffness.push_back(padding ? T(0) : random.uniform<T>(-20, 20));
          far_damping.push_back(padding ? T(0) : random.uniform<T>(-0.2, 0.2));
        }
      far_offset.push_back(far_offset.back() + s % 5);
    }
  }

  Outputs compute(Device& device, Index parts) const {
    const auto near_offset_d = upload(device, near_offset),
               near_place_d = upload(device, near_place);
    const auto near_column_d = upload(device, near_column);
    const auto near_k = upload(device, near_stiffness), near_b = upload(device, near_damping);
    const auto far_offset_d = upload(device, far_offset);
    const auto far_column_d = upload(device, far_column);
    const auto far_k = upload(device, far_stiffness), far_b = upload(device, far_damping);
    const auto x = upload(device, positions), v = upload(device, velocities);
    const auto mesh_value_d = upload(device, mesh_value);
    const auto far_value_d = upload(device, std::vector<T>(far_column.size(), T(7)));
    const auto rhs_d = upload(device, rhs);
    for (const auto& [begin, size] : parts_of(row_count, parts, slice)) {
      const auto b = static_cast<std::size_t>(begin), s = b / slice;
      launch(device.compute(),
             AssemblePlate<T>{row_begin + begin, size, slice,
                              near_offset_d.span().subspan(b, near_offset.size() - b),
                              near_place_d.span(), near_column_d.span(), near_k.span(),
                              near_b.span(), far_offset_d.span().subspan(s, far_offset.size() - s),
                              far_column_d.span(), far_k.span(), far_b.span(), x.span(), v.span(),
                              h, mesh_value_d.span(), far_value_d.span(),
                              rhs_d.span().subspan(b, static_cast<std::size_t>(size))});
    }
    return {output("mesh value", download(mesh_value_d)),
            output("far value", rows_only(download(far_value_d))), output("rhs", download(rhs_d))};
  }
  /// Lanes beyond the last row belong to nobody.
  std::vector<double> rows_only(const std::vector<T>& values) const {
    std::vector<double> own;
    for (Index r = 0; r < row_count; ++r)
      for (Offset slot = far_offset[static_cast<std::size_t>(r / slice)];
           slot < far_offset[static_cast<std::size_t>(r / slice) + 1]; ++slot)
        own.push_back(double{values[static_cast<std::size_t>(slot * slice + r % slice)]});
    return own;
  }

  Outputs reference() const {
    std::vector<double> mesh(mesh_value.begin(), mesh_value.end()), far;
    std::vector<Vec3<double>> sums;
    const double step = double{h};
    for (Index r = 0; r < row_count; ++r) {
      Vec3<double> force{};
      const auto add = [&](Index column, double k, double b) {
        const auto i = static_cast<std::size_t>(row_begin + r),
                   j = static_cast<std::size_t>(column);
        force += k * (vec_cast<double>(positions[i]) - vec_cast<double>(positions[j]));
        if (with_velocities)
          force += b * (vec_cast<double>(velocities[i]) - vec_cast<double>(velocities[j]));
        return step * step * k + step * b;
      };
      for (auto e = static_cast<std::size_t>(near_offset[static_cast<std::size_t>(r)]);
           e < static_cast<std::size_t>(near_offset[static_cast<std::size_t>(r) + 1]); ++e) {
        const double value =
            add(near_column[e], double{near_stiffness[e]}, double{near_damping[e]});
        for (const std::size_t k : {0u, 4u, 8u})
          mesh[static_cast<std::size_t>(near_place[e]) + k * slice] += value;
      }
      for (Offset slot = far_offset[static_cast<std::size_t>(r / slice)];
           slot < far_offset[static_cast<std::size_t>(r / slice) + 1]; ++slot) {
        const auto e = static_cast<std::size_t>(slot * slice + r % slice);
        far.push_back(add(far_column[e], double{far_stiffness[e]}, double{far_damping[e]}));
      }
      sums.push_back(vec_cast<double>(rhs[static_cast<std::size_t>(r)]) + step * force);
    }
    return {output("mesh value", mesh), output("far value", far), output("rhs", sums)};
  }
};

using Cases = testing::Types<PlateCase<float, true>, PlateCase<float, false>,
                             PlateCase<double, true>, PlateCase<double, false>>;
INSTANTIATE_TYPED_TEST_SUITE_P(AssemblePlate, KernelParity, Cases);

}  // namespace
}  // namespace weft::parity
