#include "weft/kernels/solve/precondition.hpp"

#include <Eigen/Dense>

#include "tests/parity/solve/system.hpp"

namespace weft::parity {
namespace {

/// Rows 40 to 339 of 400 vertices; every third row touches the next.
template <class T, bool with_contact, Index slice>
struct PreconditionCase {
  using Scalar = T;
  static constexpr Index count = 400, row_begin = 40, row_count = 300;
  Random random{7};
  std::vector<Mat3<T>> mesh;
  std::vector<ContactOperatorEntry<double>> links;
  std::vector<unsigned char> fixed = random.marks(count, 7);
  std::vector<Eigen::Matrix3d> diagonal;

  PreconditionCase() {
    for (Index r = 0; r < row_count; ++r) {
      mesh.push_back(positive(2));
      diagonal.push_back(matrix(mesh.back()));
    }
    if (!with_contact) return;
    for (Index r = 0; r + 1 < row_count; r += 3) {
      const Mat3<T> touch = positive(1);
      const Index v = row_begin + r;
      links.push_back(
          {{v, v + 1, v, v},
           {1, -0.5, 0, 0},
           {touch(0, 0), touch(0, 1), touch(0, 2), touch(1, 1), touch(1, 2), touch(2, 2)}});
      diagonal[static_cast<std::size_t>(r)] += matrix(touch);
      diagonal[static_cast<std::size_t>(r) + 1] += 0.25 * matrix(touch);
    }
  }
  /// Symmetric, diagonal from `size` to twice that, the rest below a quarter of it.
  Mat3<T> positive(double size) {
    Mat3<T> m{};
    for (int i = 0; i < 3; ++i) {
      m(i, i) = random.uniform<T>(size, 2 * size);
      for (int j = 0; j < i; ++j) m(i, j) = m(j, i) = random.uniform<T>(-size / 4, size / 4);
    }
    return m;
  }
  static Eigen::Matrix3d matrix(const Mat3<T>& m) {
    Eigen::Matrix3d result;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) result(i, j) = double{m(i, j)};
    return result;
  }

  Outputs compute(Device& device, Index parts) const {
    const auto mesh_d = upload(device, mesh);
    const auto fixed_d = upload(device, fixed);
    const Buffer<T> inverse(device, RowBlocks<T>::size(row_count, slice));
    for (const auto& [begin, size] : parts_of(row_count, parts, 32)) {
      const Index first = row_begin + begin;
      const ContactOperatorRows<T> links_d(device, links, first, first + size);
      const auto b = static_cast<std::size_t>(begin), n = static_cast<std::size_t>(size);
      launch(device.compute(),
             Precondition<T>{first, size, mesh_d.span().subspan(b, n), links_d.view(),
                             fixed_d.span(), RowBlocks<T>{slice, inverse.span()}.from(begin)});
      device.compute().sync();
    }
    const std::vector<T> values = download(inverse);
    std::vector<Mat3<T>> blocks;
    for (Index r = 0; r < row_count; ++r)
      blocks.push_back(RowBlocks<const T>{slice, {values.data(), values.size()}}.load(r));
    return {output("inverse", blocks)};
  }

  Outputs reference() const {
    std::vector<Mat3<double>> inverse;
    for (Index r = 0; r < row_count; ++r) {
      Mat3<double> result{};
      if (fixed[static_cast<std::size_t>(row_begin + r)] == 0) {
        const Eigen::Matrix3d m = diagonal[static_cast<std::size_t>(r)].inverse();
        for (int i = 0; i < 3; ++i)
          for (int j = 0; j < 3; ++j) result(i, j) = m(i, j);
      }
      inverse.push_back(result);
    }
    return {output("inverse", inverse)};
  }
};

using Cases =
    testing::Types<PreconditionCase<float, true, 1>, PreconditionCase<float, false, 32>,
                   PreconditionCase<double, true, 32>, PreconditionCase<double, false, 1>>;
INSTANTIATE_TYPED_TEST_SUITE_P(Precondition, KernelParity, Cases);

}  // namespace
}  // namespace weft::parity
