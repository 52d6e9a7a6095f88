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
  std::vector<Offset> in_pattern_offset{0}, in_pattern_place, off_pattern_offset{0};
  std::vector<Index> in_pattern_column, off_pattern_column;
  std::vector<T> in_pattern_stiffness, in_pattern_damping, off_pattern_stiffness,
      off_pattern_damping;
  std::vector<Vec3<T>> positions = random.vectors<T>(count, -1, 1);
  std::vector<Vec3<T>> velocities =
      with_velocities ? random.vectors<T>(count, -1, 1) : std::vector<Vec3<T>>{};
  std::vector<T> mesh_value =
      random.numbers<T>(static_cast<std::size_t>(9 * slices * mesh_slots * slice), -1, 1);
  std::vector<Mat3<T>> diagonal;
  std::vector<Vec3<T>> rhs = random.vectors<T>(row_count, -1e-2, 1e-2);
  T h = T(0.0078125);

  PlateCase() {
    for (Index r = 0; r < row_count; ++r) {
      diagonal.emplace_back();
      for (T& value : diagonal.back().e) value = random.uniform<T>(-1, 1);
      for (Index slot = 0; slot < mesh_slots - r % 2; ++slot) {
        in_pattern_place.push_back(Offset{(r / slice * mesh_slots + slot) * 9} * slice + r % slice);
        in_pattern_column.push_back((row_begin + r + 3 * slot + 1) % count);
        in_pattern_stiffness.push_back(random.uniform<T>(-50, 50));
        in_pattern_damping.push_back(random.uniform<T>(-0.5, 0.5));
      }
      in_pattern_offset.push_back(static_cast<Offset>(in_pattern_place.size()));
    }
    for (Index s = 0; s < slices; ++s) {
      for (Index slot = 0; slot < s % 5; ++slot)
        for (Index lane = 0; lane < slice; ++lane) {
          const Index row = std::min(s * slice + lane, row_count - 1);
          const bool padding = (row + slot) % 3 == 0;
          off_pattern_column.push_back(padding ? row_begin + row
                                               : (row_begin + row + 50 + slot) % count);
          off_pattern_stiffness.push_back(padding ? T(0) : random.uniform<T>(-20, 20));
          off_pattern_damping.push_back(padding ? T(0) : random.uniform<T>(-0.2, 0.2));
        }
      off_pattern_offset.push_back(off_pattern_offset.back() + s % 5);
    }
  }

  Outputs compute(Device& device, Index parts) const {
    const auto in_pattern_offset_d = upload(device, in_pattern_offset),
               in_pattern_place_d = upload(device, in_pattern_place);
    const auto in_pattern_column_d = upload(device, in_pattern_column);
    const auto near_k = upload(device, in_pattern_stiffness),
               near_b = upload(device, in_pattern_damping);
    const auto off_pattern_offset_d = upload(device, off_pattern_offset);
    const auto off_pattern_column_d = upload(device, off_pattern_column);
    const auto far_k = upload(device, off_pattern_stiffness),
               far_b = upload(device, off_pattern_damping);
    const auto x = upload(device, positions), v = upload(device, velocities);
    const auto mesh_value_d = upload(device, mesh_value);
    const auto off_pattern_value_d =
        upload(device, std::vector<T>(off_pattern_column.size(), T(7)));
    const auto diagonal_d = upload(device, diagonal);
    const auto rhs_d = upload(device, rhs);
    for (const auto& [begin, size] : parts_of(row_count, parts, slice)) {
      const auto b = static_cast<std::size_t>(begin), s = b / slice;
      const auto n = static_cast<std::size_t>(size);
      launch(device.compute(),
             AssemblePlate<T>{row_begin + begin, size, slice,
                              in_pattern_offset_d.span().subspan(b, in_pattern_offset.size() - b),
                              in_pattern_place_d.span(), in_pattern_column_d.span(), near_k.span(),
                              near_b.span(),
                              off_pattern_offset_d.span().subspan(s, off_pattern_offset.size() - s),
                              off_pattern_column_d.span(), far_k.span(), far_b.span(), x.span(),
                              v.span(), h, mesh_value_d.span(), diagonal_d.span().subspan(b, n),
                              off_pattern_value_d.span(), rhs_d.span().subspan(b, n)});
    }
    return {output("mesh value", download(mesh_value_d)), output("diagonal", download(diagonal_d)),
            output("far value", rows_only(download(off_pattern_value_d))),
            output("rhs", download(rhs_d))};
  }
  /// Lanes beyond the last row belong to nobody.
  std::vector<double> rows_only(const std::vector<T>& values) const {
    std::vector<double> own;
    for (Index r = 0; r < row_count; ++r)
      for (Offset slot = off_pattern_offset[static_cast<std::size_t>(r / slice)];
           slot < off_pattern_offset[static_cast<std::size_t>(r / slice) + 1]; ++slot)
        own.push_back(double{values[static_cast<std::size_t>(slot * slice + r % slice)]});
    return own;
  }

  Outputs reference() const {
    std::vector<double> mesh(mesh_value.begin(), mesh_value.end()), far;
    std::vector<Mat3<double>> own;
    std::vector<Vec3<double>> sums;
    const double step = double{h};
    for (Index r = 0; r < row_count; ++r) {
      Vec3<double> force{};
      double sum = 0;
      const auto add = [&](Index column, double k, double b) {
        const auto i = static_cast<std::size_t>(row_begin + r),
                   j = static_cast<std::size_t>(column);
        force += k * (vec_cast<double>(positions[i]) - vec_cast<double>(positions[j]));
        if (with_velocities)
          force += b * (vec_cast<double>(velocities[i]) - vec_cast<double>(velocities[j]));
        sum += step * step * k + step * b;
        return step * step * k + step * b;
      };
      for (auto e = static_cast<std::size_t>(in_pattern_offset[static_cast<std::size_t>(r)]);
           e < static_cast<std::size_t>(in_pattern_offset[static_cast<std::size_t>(r) + 1]); ++e) {
        const double value = add(in_pattern_column[e], double{in_pattern_stiffness[e]},
                                 double{in_pattern_damping[e]});
        for (const std::size_t k : {0u, 4u, 8u})
          mesh[static_cast<std::size_t>(in_pattern_place[e]) + k * slice] += value;
      }
      for (Offset slot = off_pattern_offset[static_cast<std::size_t>(r / slice)];
           slot < off_pattern_offset[static_cast<std::size_t>(r / slice) + 1]; ++slot) {
        const auto e = static_cast<std::size_t>(slot * slice + r % slice);
        far.push_back(add(off_pattern_column[e], double{off_pattern_stiffness[e]},
                          double{off_pattern_damping[e]}));
      }
      own.emplace_back();
      for (int k = 0; k < 9; ++k)
        own.back().e[k] =
            double{diagonal[static_cast<std::size_t>(r)].e[k]} - (k % 4 == 0 ? sum : 0);
      sums.push_back(vec_cast<double>(rhs[static_cast<std::size_t>(r)]) + step * force);
    }
    return {output("mesh value", mesh), output("diagonal", own), output("far value", far),
            output("rhs", sums)};
  }
};

using Cases = testing::Types<PlateCase<float, true>, PlateCase<float, false>,
                             PlateCase<double, true>, PlateCase<double, false>>;
INSTANTIATE_TYPED_TEST_SUITE_P(AssemblePlate, KernelParity, Cases);

}  // namespace
}  // namespace weft::parity
