#pragma once

#include "host/implicit/linear/pipelined_solve.hpp"
#include "tests/parity/solve/system.hpp"
#include "weft/kernels/solve/halo.hpp"
#include "weft/kernels/solve/pcg.hpp"
#include "weft/kernels/solve/precondition.hpp"
#include "weft/scene.hpp"

namespace weft::parity {

/// Of a solve.
struct Options {
  Index partial_rows = 64;
  Preconditioner preconditioner = Preconditioner::multilevel;
  double tolerance = 1e-5;
  std::int32_t max_iterations = 1000;
  Transport transport = Transport::peer;
  double scale_min = 0;
  double left_max = 0;
  double gain = 0;
  Vec3<double> guess{};   ///< of free vertices
  double pause = 0;       ///< share of the residual at which the solve pauses; 0: none
  double pause_left = 0;  ///< see SolvePcg
};

/// Initial guess of fixed vertices, which they keep.
inline Vec3<double> prescribed(Index v) {
  return {0.5, -0.25 * (v % 3), 0.125};
}

/// Everything that one rank needs.
template <class T>
class SolveRank {
 public:
  SolveRank(Device& device, const SheetSystem& system, const Options& options, Index begin,
            Index end, const std::vector<Index>& row_begin)
      : begin_(begin),
        end_(end),
        device_(&device),
        mesh_(device, system.mesh, begin, end, slice(device)),
        contact_(device, system.links, begin, end),
        far_(device, system.far, begin, end, slice(device), mesh_.order),
        fixed_(upload(device, system.fixed)),
        row_begin_(upload(device, row_begin)),
        mesh_ghost_(upload(device, ghosts(system))) {
    const auto own = static_cast<std::size_t>(end - begin);
    const auto all = static_cast<std::size_t>(system.count);
    std::vector<Vec3<T>> b, guess;
    for (std::size_t v = 0; v < all; ++v)
      guess.push_back(system.fixed[v] != 0 ? vec_cast<T>(prescribed(static_cast<Index>(v)))
                                           : vec_cast<T>(options.guess));
    for (Index v = begin; v < end; ++v)
      b.push_back(vec_cast<T>(system.rhs[static_cast<std::size_t>(v)]));
    rhs_ = upload(device, b);
    std::vector<T> drag(system.drag.empty() ? 0 : RowBlocks<T>::size(rows(), block_slice()));
    for (Index v = begin; v < end && !drag.empty(); ++v) {
      Mat3<T> block;
      for (int k = 0; k < 9; ++k)
        block.e[k] = static_cast<T>(system.drag[static_cast<std::size_t>(v)].e[k]);
      RowBlocks<T>{block_slice(), {drag.data(), drag.size()}}.store(v - begin, block);
    }
    drag_ = upload(device, drag);
    mass_ = upload(device, std::vector<T>(system.mass.begin() + begin, system.mass.begin() + end));
    x_ = upload(device, guess);
    inverse_ = Buffer<T>(device, RowBlocks<T>::size(rows(), block_slice()));
    for (auto* vector : {&u_, &r_, &w_, &p_, &s_})
      *vector = Buffer<Vec3<T>>(device, vector == &u_ ? all : own);
    stamp_ = upload(device, std::vector<Index>(all, 0));
    ghost_ = Buffer<Index>(device, all);
    ghost_offset_ = Buffer<Index>(device, row_begin.size());
    partial_ = Buffer<double>(
        device, 6 * static_cast<std::size_t>(pcg_partials(system.count, options.partial_rows)));
    ready_ = upload(device, std::vector<std::uint32_t>(pcg_flags, 0));
    receivers_ = Buffer<std::uint32_t>(device, own);
    status_ = Buffer<SolveStatus>(device, 1);
    if (options.preconditioner == Preconditioner::multilevel) {
      fine_ = FineLevel<T>::of(options.partial_rows);
      wide_ = WideLevel<T>::of(options.partial_rows);
      make_level(fine_, fine_inverse_);
      make_level(wide_, wide_inverse_);
      if (wide_.aggregates > 0)
        wide_sum_ = Buffer<double>(
            device, static_cast<std::size_t>(fine_.domains(rows()) * FineLevel<T>::wide_sums));
    }
  }

  /// All that goes before the solve.
  void prepare(int rank) {
    Queue& queue = device_->compute();
    launch(queue, SolveHalo<T>{rank, row_begin_.span(), mesh_ghost_.span(), contact_.view(),
                               stamp_.span(), 1, ghost_.span(), ghost_offset_.span()});
    launch(queue, Precondition<T>{begin_,
                                  rows(),
                                  mesh_.diagonal.span(),
                                  contact_.view(),
                                  fixed_.span(),
                                  {block_slice(), inverse_.span()}});
    if (fine_.aggregates > 0)
      launch(queue, SolveSchwarzLevels<T>{begin_, mesh_.blocks(), far_.scalars(), contact_.view(),
                                          fixed_.span(), fine_, wide_, wide_sum_.span()});
    queue.sync();
  }

  SolvePcgPart<T> part() const {
    SolvePcgPart<T> part;
    part.mesh = mesh_.blocks();
    part.far = far_.scalars();
    part.vertex = {mass_.span(), {block_slice(), drag_.span()}};
    part.contact = contact_.view();
    part.inverse = {block_slice(), inverse_.span()};
    part.fine = fine_;
    part.wide = wide_;
    part.fixed = fixed_.span();
    part.rhs = rhs_.span();
    part.ghost = ghost_.span();
    part.ghost_offset = ghost_offset_.span();
    part.x = x_.span();
    part.u = u_.span();
    part.r = r_.span();
    part.w = w_.span();
    part.p = p_.span();
    part.s = s_.span();
    part.partial = partial_.span();
    part.ready = ready_.span();
    part.receivers = receivers_.span();
    part.status = status_.span();
    return part;
  }
  Span<const SolvePcgPart<T>> take(const std::vector<SolvePcgPart<T>>& parts) {
    parts_ = upload(*device_, parts);
    return parts_.span();
  }
  Span<const Index> row_begin() const { return row_begin_.span(); }
  Index rows() const { return end_ - begin_; }
  SolveStatus status() const { return download(status_).front(); }
  /// Own rows of the solution go to `all`.
  void collect(std::vector<Vec3<T>>& all) const {
    const std::vector<Vec3<T>> mine = download(x_);
    std::copy(mine.begin() + begin_, mine.begin() + end_, all.begin() + begin_);
  }

 private:
  static Index slice(const Device& device) {
    return device.backend() == Backend::host ? host_slice : cuda_slice;
  }
  std::vector<Index> ghosts(const SheetSystem& system) const {
    std::map<Index, bool> found;
    for (Index v = begin_; v < end_; ++v) {
      for (const auto& entry : system.mesh[SheetSystem::at(v)]) found[entry.first] = true;
      for (const auto& entry : system.far[SheetSystem::at(v)]) found[entry.first] = true;
    }
    std::vector<Index> result;
    for (const auto& entry : found)
      if (entry.first < begin_ || entry.first >= end_) result.push_back(entry.first);
    return result;
  }
  Index block_slice() const { return device_->backend() == Backend::cuda ? cuda_slice : 1; }
  template <class Level>
  void make_level(Level& level, Buffer<T>& inverse) {
    if (level.aggregates == 0) return;
    inverse = Buffer<T>(*device_,
                        static_cast<std::size_t>(level.domains(rows()) * level.domain_numbers()));
    level.inverse = inverse.span();
  }

  Index begin_, end_;
  Device* device_;
  MeshMatrixRows<T> mesh_;
  ContactOperatorRows<T> contact_;
  SlicedRows<T> far_;
  Buffer<unsigned char> fixed_;
  Buffer<Index> row_begin_, mesh_ghost_, stamp_, ghost_, ghost_offset_;
  Buffer<T> mass_;
  Buffer<T> drag_;
  Buffer<Vec3<T>> rhs_, x_, u_, r_, w_, p_, s_;
  Buffer<T> inverse_, fine_inverse_, wide_inverse_;
  Buffer<double> wide_sum_;
  FineLevel<T> fine_;
  WideLevel<T> wide_;
  Buffer<double> partial_;
  Buffer<std::uint32_t> ready_, receivers_;
  Buffer<SolveStatus> status_;
  Buffer<SolvePcgPart<T>> parts_;
};

template <class T>
struct Solution {
  std::vector<Vec3<T>> x;
  SolveStatus status;
  std::int32_t paused_iterations = 0;  ///< at which it paused
  Outputs outputs() const {
    return {output("x", x), output("iterations", std::vector<double>{double(status.iterations)}),
            output("residual", std::vector<double>{status.residual})};
  }
};

/// Rows go to the ranks in whole partial sums; a rank may get none.
template <class T>
Solution<T> solve(const DeviceSet& set, const SheetSystem& system, const Options& options) {
  auto& devices = const_cast<DeviceSet&>(set);
  const Index partials = (system.count + options.partial_rows - 1) / options.partial_rows;
  std::vector<Index> row_begin;
  for (int r = 0; r <= devices.size(); ++r)
    row_begin.push_back(
        std::min(system.count, partials * r / devices.size() * options.partial_rows));
  std::vector<SolveRank<T>> ranks;
  for (int r = 0; r < devices.size(); ++r)
    ranks.emplace_back(devices[r], system, options, row_begin[static_cast<std::size_t>(r)],
                       row_begin[static_cast<std::size_t>(r) + 1], row_begin);
  std::vector<SolvePcgPart<T>> parts;
  for (int r = 0; r < devices.size(); ++r) {
    ranks[static_cast<std::size_t>(r)].prepare(r);
    parts.push_back(ranks[static_cast<std::size_t>(r)].part());
  }
  std::vector<SolvePcg<T>> args;
  for (int r = 0; r < devices.size(); ++r) {
    SolveRank<T>& rank = ranks[static_cast<std::size_t>(r)];
    args.push_back(
        {r, rank.take(parts), rank.row_begin(), options.partial_rows, 0, options.tolerance, 0,
         options.scale_min, options.left_max, options.max_iterations, rank.rows(),
         options.preconditioner != Preconditioner::block_jacobi,
         devices.backend() == Backend::cuda && !system.links.empty(), nullptr, 0, options.gain});
  }
  const auto run = [&] {
    if (options.transport == Transport::pipelined)
      PipelinedSolve<T>(devices, row_begin, options.partial_rows).solve(args, parts);
    else
      launch_collective(devices, args);
    for (int r = 0; r < devices.size(); ++r) devices[r].compute().sync();
    return ranks.front().status();
  };
  std::int32_t paused_iterations = 0;
  if (options.pause > 0 || options.pause_left > 0) {
    for (SolvePcg<T>& a : args) {
      a.pause = options.pause;
      a.pause_left = options.pause_left;
    }
    const SolveStatus paused = run();
    EXPECT_EQ(paused.paused, 1);
    EXPECT_EQ(paused.converged, 0);
    paused_iterations = paused.iterations;
    for (SolvePcg<T>& a : args) {
      a.pause = 0;
      a.pause_left = 0;
      a.epoch += pcg_epochs(options.max_iterations);
      a.resume = true;
    }
  }
  const SolveStatus status = run();
  Solution<T> solution{std::vector<Vec3<T>>(static_cast<std::size_t>(system.count)), status,
                       paused_iterations};
  for (const SolveRank<T>& rank : ranks) {
    rank.collect(solution.x);
    EXPECT_EQ(rank.status().iterations, solution.status.iterations);
  }
  return solution;
}

}  // namespace weft::parity
