#include "weft/kernels/solve/sparse_inverse.hpp"

#include <Eigen/Dense>

#include "tests/parity/solve/solve_rank.hpp"

namespace weft::parity {
namespace {

/// A factor of a system, made on a device. Slices of 32 rows on all, so that places are the same.
template <class T>
struct MadeSparseInverse {
  std::vector<SparseInverseEntry> lower, upper;

  MadeSparseInverse(Device& device, const SheetSystem& system) {
    const MeshMatrixRows<T> mesh(device, system.mesh, 0, system.count, cuda_slice);
    const SlicedRows<T> far(device, system.far, 0, system.count, cuda_slice);
    const ContactRows<T> contact(device, system, 0, system.count);
    const Buffer<unsigned char> fixed = upload(device, system.fixed);
    SparseInverseBuffers factor;
    factor.make(device, sparse_inverse_pattern_of(system, 0, system.count, 1024), cuda_slice);
    launch(device.compute(), SolveSparseInverse<T>{0, mesh.blocks(), far.scalars(), contact.view(),
                                                   fixed.span(), factor.view()});
    const auto get = [&](Span<SparseInverseEntry> from) {
      std::vector<SparseInverseEntry> to(from.size());
      device.compute().copy(to.data(), from.data(), to.size() * sizeof(SparseInverseEntry));
      device.compute().sync();
      return to;
    };
    lower = get(factor.view().lower);
    upper = get(factor.view().upper);
  }
};

Eigen::Matrix3d block(const SparseInverseEntry& e) {
  Eigen::Matrix3d m;
  for (int k = 0; k < 9; ++k)
    m(k / 3, k % 3) = double(sparse_inverse_scale(e)) * (e.value[k] - sparse_inverse_zero);
  return m;
}

/// Roundings to 8 bits may fall to either side, and to either scale.
void expect_alike(const std::vector<SparseInverseEntry>& a,
                  const std::vector<SparseInverseEntry>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t n = 0; n < a.size(); ++n) {
    EXPECT_EQ(a[n].column, b[n].column);
    const double step = std::max(sparse_inverse_scale(a[n]), sparse_inverse_scale(b[n]));
    EXPECT_LE((block(a[n]) - block(b[n])).cwiseAbs().maxCoeff(), 1.5 * step) << n;
  }
}

template <class T>
class SolveSparseInverseTest : public testing::Test {
 protected:
  SheetSystem system_{23, 19, 29};
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(SolveSparseInverseTest, Scalars);

TYPED_TEST(SolveSparseInverseTest, CudaAgreesWithHost) {
  std::string why;
  const std::optional<DeviceSet> cuda = find_cuda({0}, why);
  if (!cuda) GTEST_SKIP() << why;
  const DeviceSet host = host_devices(1, {.poison = true});
  const MadeSparseInverse<TypeParam> there(const_cast<DeviceSet&>(*cuda)[0], this->system_);
  const MadeSparseInverse<TypeParam> here(const_cast<DeviceSet&>(host)[0], this->system_);
  expect_alike(there.lower, here.lower);
  expect_alike(there.upper, here.upper);
}

/// Where each row has entries for all before it, G^T G is the inverse, up to the rounding of G.
TYPED_TEST(SolveSparseInverseTest, OfFewRowsIsTheirInverse) {
  constexpr Index rows = 6;
  SheetSystem system(3, 2, 5);
  system.fixed.assign(rows, 0);
  system.part_contacts();
  const DeviceSet host = host_devices(1, {.poison = true});
  const MadeSparseInverse<TypeParam> made(const_cast<DeviceSet&>(host)[0], system);
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(3 * rows, 3 * rows), g = matrix,
                  transpose = matrix;
  for (Index v = 0; v < rows; ++v) {
    for (const auto& [column, b] : system.mesh[SheetSystem::at(v)])
      for (int k = 0; k < 9; ++k) matrix(3 * v + k / 3, 3 * column + k % 3) += b.e[k];
    for (const auto& [column, value] : system.far[SheetSystem::at(v)])
      for (int k = 0; k < 3; ++k) matrix(3 * v + k, 3 * column + k) += value;
    for (std::size_t n = static_cast<std::size_t>(v); n < made.lower.size(); n += cuda_slice)
      g.block<3, 3>(3 * v, 3 * made.lower[n].column) += block(made.lower[n]);
    for (std::size_t n = static_cast<std::size_t>(v); n < made.upper.size(); n += cuda_slice)
      transpose.block<3, 3>(3 * v, 3 * made.upper[n].column) += block(made.upper[n]);
  }
  EXPECT_EQ((g - transpose.transpose()).norm(), 0);
  const Eigen::MatrixXd identity = g * matrix * g.transpose();
  EXPECT_LT((identity - Eigen::MatrixXd::Identity(3 * rows, 3 * rows)).norm(), 0.1);
}

TYPED_TEST(SolveSparseInverseTest, FixedRowsGetZeros) {
  const DeviceSet host = host_devices(1, {.poison = true});
  const MadeSparseInverse<TypeParam> made(const_cast<DeviceSet&>(host)[0], this->system_);
  const auto lanes = static_cast<std::size_t>(cuda_slice);
  int seen = 0;
  for (std::size_t n = 0; n < made.lower.size(); ++n) {
    const std::size_t row = n / (sparse_inverse_width * lanes) * lanes + n % lanes;
    if (row >= this->system_.fixed.size()) continue;
    const auto column = static_cast<std::size_t>(made.lower[n].column);
    if (this->system_.fixed[row] == 0 && this->system_.fixed[column] == 0) continue;
    EXPECT_EQ(block(made.lower[n]).norm(), 0);
    ++seen;
  }
  EXPECT_GT(seen, 0);
}

}  // namespace
}  // namespace weft::parity
