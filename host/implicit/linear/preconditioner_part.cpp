#include <algorithm>

#include "host/implicit/linear/linear_system.hpp"
#include "host/implicit/parallel/exchange.hpp"
#include "weft/kernels/solve/galerkin_product.hpp"
#include "weft/kernels/solve/schwarz_level.hpp"
#include "weft/kernels/solve/sparse_inverse.hpp"

namespace weft {

/// Memory of what the preconditioner has beside block Jacobi.
template <class T>
void LinearSystem<T>::make_preconditioner(int r, const MeshRows& rows) {
  const Preconditioner chosen = store_.scene().solver.preconditioner;
  const Partition& partition = store_.partition();
  Device& device = store_.devices()[r];
  Rank& rank = ranks_[static_cast<std::size_t>(r)];
  const auto own = static_cast<std::size_t>(row_count(r));
  for (int level = 0; level < schwarz_level_count; ++level) {
    const SchwarzLevel<T> c = coarse_level(r, level);
    if (c.aggregates == 0) continue;
    const auto domain = static_cast<std::size_t>(c.domain_rows());
    rank.schwarz_inverse[level] = Buffer<T>(
        device, (own + domain - 1) / domain * static_cast<std::size_t>(c.size() * c.size()));
  }
  if (chosen == Preconditioner::multilevel_linear)
    rank.modes.make(device,
                    make_coarse_basis_table(store_.model().material_points,
                                            std::min(partition.partial_rows, pcg_partial_rows_max)),
                    row_begin(r), row_count(r));
  if (chosen != Preconditioner::sparse_inverse) return;
  const auto points = store_.model().material_points.begin() + row_begin(r);
  rank.factor.make(
      device,
      sparse_inverse_pattern(mesh_neighbours(rows.slice_offset, rows.column, partition.slice,
                                             row_begin(r), row_count(r)),
                             {points, points + row_count(r)},
                             sparse_inverse_domain(partition.partial_rows)),
      partition.slice);
}

template <class T>
void LinearSystem<T>::launch_sparse_inverse(int r) {
  const auto n = static_cast<std::size_t>(r);
  if (!ranks_[n].factor.any()) return;
  launch(store_.devices()[r].compute(),
         SolveSparseInverse<T>{row_begin(r), mesh_view(r), far_view(r), contact_view(r),
                               geometry_[n].fixed.span(), ranks_[n].factor.view()});
}

/// Level of the preconditioner that rank r works with; without aggregates if it is not in use.
template <class T>
SchwarzLevel<T> LinearSystem<T>::coarse_level(int r, int level) const {
  const Preconditioner chosen = store_.scene().solver.preconditioner;
  // The factor does what the finest level would.
  const bool used = chosen == Preconditioner::multilevel ||
                    (chosen == Preconditioner::sparse_inverse && level > 0);
  if (!used) return {};
  const Index aggregates = schwarz_aggregates(level, store_.partition().partial_rows);
  if (aggregates < 2) return {};
  return {schwarz_shift(level), aggregates,
          ranks_[static_cast<std::size_t>(r)].schwarz_inverse[level].span()};
}

template <class T>
void LinearSystem<T>::launch_coarse(int r) {
  for (int level = 0; level < schwarz_level_count; ++level) {
    const SchwarzLevel<T> c = coarse_level(r, level);
    if (c.aggregates > 0)
      launch(store_.devices()[r].compute(),
             SolveSchwarzLevel<T>{row_begin(r), mesh_view(r), far_view(r), contact_view(r),
                                  geometry_[static_cast<std::size_t>(r)].fixed.span(), c});
  }
}

/// Rebuilds the levels of aggregates with linear modes, on all ranks: each has a part of what
/// they follow from, and all of what comes of it.
template <class T>
void LinearSystem<T>::refresh_coarse_basis() {
  if (!ranks_.front().modes.any()) return;
  std::vector<GatherPiece> pieces;
  for (int r = 0; r < store_.devices().size(); ++r) {
    const auto n = static_cast<std::size_t>(r);
    CoarseBasisBuffers<T>& modes = ranks_[n].modes;
    pieces.push_back(modes.own_strips());
    launch(store_.devices()[r].compute(),
           SolveGalerkinProduct<T>{
               row_begin(r), mesh_view(r), far_view(r), contact_view(r), geometry_[n].fixed.span(),
               modes.view(), modes.strip().subspan(pieces.back().begin, pieces.back().count)});
  }
  const auto strip = [&](int r) { return ranks_[static_cast<std::size_t>(r)].modes.strip(); };
  all_gather(
      store_.devices(), pieces, sizeof(double),
      [&](int r) { return strip(r).data() + pieces[static_cast<std::size_t>(r)].begin; },
      [&](int r) { return strip(r).data(); });
  for (int r = 0; r < store_.devices().size(); ++r)
    ranks_[static_cast<std::size_t>(r)].modes.launch_coarse_inverse(store_.devices()[r].compute());
}

template void LinearSystem<float>::make_preconditioner(int, const MeshRows&);
template void LinearSystem<double>::make_preconditioner(int, const MeshRows&);
template SchwarzLevel<float> LinearSystem<float>::coarse_level(int, int) const;
template SchwarzLevel<double> LinearSystem<double>::coarse_level(int, int) const;
template void LinearSystem<float>::launch_sparse_inverse(int);
template void LinearSystem<double>::launch_sparse_inverse(int);
template void LinearSystem<float>::launch_coarse(int);
template void LinearSystem<double>::launch_coarse(int);
template void LinearSystem<float>::refresh_coarse_basis();
template void LinearSystem<double>::refresh_coarse_basis();

}  // namespace weft
