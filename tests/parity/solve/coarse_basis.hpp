#pragma once

#include <Eigen/Dense>

#include "host/implicit/linear/preconditioners/coarse_basis_buffers.hpp"
#include "tests/parity/solve/system.hpp"
#include "weft/kernels/solve/galerkin_product.hpp"

namespace weft::parity {

/// Material coordinates of a sheet system's vertices, uneven so that no mode is like another.
inline std::vector<Vec2<double>> material_points(const SheetSystem& system) {
  std::vector<Vec2<double>> points;
  for (Index v = 0; v < system.count; ++v) {
    const double i = v % system.across, j = v / system.across;
    points.push_back({i + 0.2 * std::sin(3 * j), 1.5 * j + 0.01 * i * i});
  }
  return points;
}

/// Places with no order in them, so that even a few vertices' modes are independent: the inverses
/// of others would magnify what rounding makes of the two sides of a comparison.
inline std::vector<Vec2<double>> scattered_points(const SheetSystem& system) {
  std::vector<Vec2<double>> points;
  for (Index v = 0; v < system.count; ++v)
    points.push_back({std::sin(1.7 * v), std::cos(2.9 * v + 0.4 * std::sin(double(v)))});
  return points;
}

/// A sheet system with aggregates of linear modes: what every domain's matrix P^T A P is, summed up
/// entry by entry with no regard to levels below, ranks and partial sums.
template <class T, Index partial_rows>
struct CoarseBasisSystem {
  SheetSystem system;
  CoarseBasisTable table;

  CoarseBasisSystem(Index across, Index up, std::uint32_t seed)
      : system(across, up, seed),
        table(make_coarse_basis_table(scattered_points(system), partial_rows)) {
    // A whole unit of fixed vertices.
    for (Index k = 0; k < table.unit_rows; ++k) system.fixed[SheetSystem::at(k)] = 1;
  }

  int upper_count() const { return static_cast<int>(table.aggregates.size()); }
  /// Rows of an aggregate of a level; level -1: of a unit.
  Index rows_of(int level) const {
    Index rows = level < 0 ? table.unit_rows : table.partial_rows;
    for (int k = 0; k < level; ++k) rows *= coarse_domain;
    return rows;
  }
  /// Aggregates of a level's domain.
  Index domain_of(int level) const {
    return level < 0 ? table.partial_rows / table.unit_rows : coarse_domain;
  }

  /// 1, u and v of a vertex on a level.
  Eigen::Vector3d modes(Index vertex, int level) const {
    const CoarseBasisPoint& p = table.point[SheetSystem::at(vertex)];
    Eigen::Vector3d m(1, p.u / 32767.0, p.v / 32767.0);
    const auto step = [&](const CoarseBasisStep<double>& s) {
      m = Eigen::Vector3d(1, s.u + s.scale * m[1], s.v + s.scale * m[2]);
    };
    if (level >= 0) step(table.unit[SheetSystem::at(vertex / table.unit_rows)]);
    for (int k = 0; k < level; ++k)
      step(table.larger[SheetSystem::at(k)][SheetSystem::at(vertex / rows_of(k))]);
    return m;
  }

  /// Inverses of all domains of a level one after the other, each of `size` rows.
  std::vector<double> inverses(int level, Index size) const {
    const Index rows = rows_of(level) * domain_of(level);
    std::vector<double> all;
    for (Index first = 0; first < system.count; first += rows) {
      Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(size, size);
      add(system.mesh, level, first, sum);
      add(system.far, level, first, sum);
      add(system.contact, level, first, sum);
      for (Index k = 0; k < size; ++k)
        sum(k, k) = sum(k, k) > 0 ? (1 + coarse_shift) * sum(k, k) : 1;
      Eigen::MatrixXd inverse = sum.inverse();
      if (level >= 0) {
        const Index left = system.count - first;
        const Index used =
            coarse_dofs * std::min(coarse_domain, (left + rows_of(level) - 1) / rows_of(level));
        for (Index k = used; k < size; ++k) inverse(k, k) = 0;
      }
      all.insert(all.end(), inverse.data(), inverse.data() + inverse.size());
    }
    return all;
  }

 private:
  template <class Entry>
  void add(const Rows<Entry>& rows, int level, Index first, Eigen::MatrixXd& sum) const {
    const Index each = rows_of(level);
    const Index last = std::min(system.count, first + each * domain_of(level));
    for (Index row = first; row < last; ++row)
      for (const auto& [column, entry] : rows[SheetSystem::at(row)]) {
        if (column < first || column >= last) continue;
        if (system.fixed[SheetSystem::at(row)] + system.fixed[SheetSystem::at(column)] > 0)
          continue;
        Eigen::Matrix3d block = Eigen::Matrix3d::Identity();
        if constexpr (std::is_arithmetic_v<Entry>)
          block *= double{static_cast<T>(entry)};
        else
          for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) block(i, j) = double{static_cast<T>(entry(i, j))};
        const Eigen::Vector3d a = modes(row, level), b = modes(column, level);
        for (int p = 0; p < coarse_basis_count; ++p)
          for (int q = 0; q < coarse_basis_count; ++q)
            sum.block<3, 3>(coarse_dofs * ((row - first) / each) + 3 * p,
                            coarse_dofs * ((column - first) / each) + 3 * q) += a[p] * b[q] * block;
      }
  }
};

/// Submits the projection of rows [first, last), after which it waits.
template <class T, Index partial_rows>
void galerkin_product_rows(Device& device, const CoarseBasisSystem<T, partial_rows>& of,
                           CoarseBasisBuffers<T>& modes, Index first, Index last) {
  const Index slice = device.backend() == Backend::host ? host_slice : cuda_slice;
  const auto fixed = upload(device, of.system.fixed);
  const MeshMatrixRows<T> mesh(device, of.system.mesh, first, last, slice);
  const SlicedRows<T> far(device, of.system.far, first, last, slice);
  const ContactRows<T> contact(device, of.system, first, last);
  CoarseBasisLevels<T> view = modes.view();
  const auto own = static_cast<std::size_t>(first / partial_rows);
  const auto fine = own * static_cast<std::size_t>(view.fine_size() * view.fine_size());
  if (view.has_fine())
    view.fine_inverse = view.fine_inverse.subspan(fine, view.fine_inverse.size() - fine);
  const std::size_t strip =
      own * static_cast<std::size_t>(view.upper_count) * coarse_dofs * coarse_domain_dofs;
  launch(device.compute(),
         SolveGalerkinProduct<T>{first, mesh.blocks(), far.scalars(), contact.view(), fixed.span(),
                                 view, modes.strip().subspan(strip, modes.strip().size() - strip)});
  device.compute().sync();
}

}  // namespace weft::parity
