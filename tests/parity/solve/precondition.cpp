#include "weft/kernels/solve/precondition.hpp"

#include <Eigen/Dense>

#include "tests/parity/solve/system.hpp"

namespace weft::parity {
namespace {

constexpr Index slice = 8;

/// A BlockEll in host memory of which each slice has `width` slots.
template <class T>
struct Matrix {
  Index row_count, width;
  std::vector<Offset> slice_offset{0};
  std::vector<Index> column;
  std::vector<T> value;

  /// All entries are padding. Lanes without a row stay as they are: nobody may read them.
  Matrix(Index rows, Index slots, Index row_begin) : row_count(rows), width(slots) {
    const Index slices = (rows + slice - 1) / slice;
    for (Index s = 0; s < slices; ++s) slice_offset.push_back(slice_offset.back() + width);
    column.assign(static_cast<std::size_t>(slices * width * slice), -1);
    value.assign(9 * column.size(), T(0));
    for (Index r = 0; r < rows; ++r)
      for (Index k = 0; k < width; ++k) column[entry(r, k)] = row_begin + r;
  }
  std::size_t entry(Index row, Index slot) const {
    return static_cast<std::size_t>((row / slice * width + slot) * slice + row % slice);
  }
  void set(Index row, Index slot, Index vertex, const Mat3<T>& block) {
    const std::size_t e = entry(row, slot);
    column[e] = vertex;
    for (std::size_t k = 0; k < 9; ++k) value[(e / slice * 9 + k) * slice + e % slice] = block.e[k];
  }
};

template <class T>
struct MatrixOnDevice {
  Buffer<Offset> slice_offset;
  Buffer<Index> column;
  Buffer<T> value;
  MatrixOnDevice(Device& device, const Matrix<T>& m)
      : slice_offset(upload(device, m.slice_offset)),
        column(upload(device, m.column)),
        value(upload(device, m.value)) {}
  /// @param begin a multiple of the slice
  BlockEll<T> rows(Index begin, Index count) const {
    const auto first = static_cast<std::size_t>(begin / slice);
    return {count, slice, slice_offset.span().subspan(first, slice_offset.size() - first),
            column.span(), value.span()};
  }
};

/// Rows 40 to 339 of 400 vertices; every third row touches the next.
template <class T, bool with_contact>
struct PreconditionCase {
  using Scalar = T;
  static constexpr Index count = 400, row_begin = 40, row_count = 300;
  Random random{7};
  std::vector<Mat3<T>> mesh;
  Matrix<T> contact{with_contact ? row_count : 0, 2, row_begin};
  std::vector<ContactOperatorEntry<double>> links;  ///< what `contact` is the sum of
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
      contact.set(r, 0, v, touch);
      contact.set(r, 1, v + 1, T(-0.5) * touch);
      contact.set(r + 1, 0, v, T(-0.5) * touch);
      contact.set(r + 1, 1, v + 1, T(0.25) * touch);
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
    const MatrixOnDevice<T> contact_d(device, contact);
    const auto fixed_d = upload(device, fixed);
    const Buffer<Mat3<T>> inverse(device, row_count);
    for (const auto& [begin, size] : parts_of(row_count, parts, slice)) {
      const Index first = row_begin + begin;
      const ContactOperatorRows<T> links_d(device, links, first, first + size);
      ContactPart<T> contacts;
      if (with_contact && device.backend() == Backend::cuda)
        contacts.links = links_d.view();
      else if (with_contact)
        contacts.matrix = contact_d.rows(begin, size);
      const auto b = static_cast<std::size_t>(begin), n = static_cast<std::size_t>(size);
      launch(device.compute(), Precondition<T>{first, size, mesh_d.span().subspan(b, n), contacts,
                                               fixed_d.span(), inverse.span().subspan(b, n)});
      device.compute().sync();
    }
    return {output("inverse", download(inverse))};
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

using Cases = testing::Types<PreconditionCase<float, true>, PreconditionCase<float, false>,
                             PreconditionCase<double, true>, PreconditionCase<double, false>>;
INSTANTIATE_TYPED_TEST_SUITE_P(Precondition, KernelParity, Cases);

}  // namespace
}  // namespace weft::parity
