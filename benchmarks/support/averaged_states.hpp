#pragma once

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "host/scene/seams/sewing.hpp"
#include "host/state/checkpoint.hpp"
#include "host/state/store.hpp"
#include "host/time_parallel/coarse_scene.hpp"
#include "host/time_parallel/coarse_states.hpp"
#include "weft/devices.hpp"
#include "weft/frame.hpp"

namespace weft::bench {

/// What the coarse level of a scene would be if it went where the fine run goes: with it recovery
/// of detail is seen by itself, without what a coarse run does differently.
class AveragedStates {
 public:
  /// @param level must outlive this
  AveragedStates(const Scene& fine, const CoarseScene& level) : level_(level) {
    const Tracking tracking = make_tracking(fine, level);
    const auto rows = static_cast<int>(tracking.offset.size()) - 1;
    const auto inputs = static_cast<int>(input_offsets(fine).back());
    std::vector<Eigen::Triplet<double>> entries;
    for (int i = 0; i < rows; ++i)
      for (auto e = tracking.offset[static_cast<std::size_t>(i)];
           e < tracking.offset[static_cast<std::size_t>(i) + 1]; ++e)
        entries.emplace_back(i, tracking.input[static_cast<std::size_t>(e)],
                             tracking.weight[static_cast<std::size_t>(e)]);
    sums_.resize(rows, inputs);
    sums_.setFromTriplets(entries.begin(), entries.end());
    entries.clear();
    int input = 0;
    for (std::size_t c = 0; c < level.maps.size(); ++c)
      for (std::size_t v = 0; v < level.maps[c].corner.size(); ++v, ++input)
        for (std::size_t k = 0; k < 3; ++k)
          entries.emplace_back(input, level.schwarz_offset[c] + level.maps[c].corner[v][k],
                               level.maps[c].weight[v][k]);
    Eigen::SparseMatrix<double> upsampling(inputs, rows);
    upsampling.setFromTriplets(entries.begin(), entries.end());
    factors_.compute(Eigen::SparseMatrix<double>(sums_ * upsampling));
  }

  /// Coarse values that, upsampled, have the sums of the fine ones over every hat function: the
  /// nearest in the mean square over the area.
  /// @param values [cloths][vertices] such as Frame::cloth_positions
  std::vector<Vec3<double>> of(const std::vector<std::vector<Vec3<double>>>& values) const {
    Eigen::MatrixXd fine(sums_.cols(), 3);
    Eigen::Index input = 0;
    for (const auto& cloth : values)
      for (const Vec3<double>& x : cloth) fine.row(input++) << x[0], x[1], x[2];
    const Eigen::MatrixXd coarse = factors_.solve(sums_ * fine);
    std::vector<Vec3<double>> result;
    for (Eigen::Index i = 0; i < coarse.rows(); ++i)
      result.push_back({coarse(i, 0), coarse(i, 1), coarse(i, 2)});
    return result;
  }

  /// Writes a state of the fine run as if the coarse run had come to it.
  /// @param directory for CoarseStates   @param step of the coarse run
  void write(const Frame& fine, const std::filesystem::path& directory, std::int64_t step) const {
    const auto file = CoarseStates::file(directory, step);
    if (level_.scene.precision == Precision::single_precision)
      write_as<float>(fine, file);
    else
      write_as<double>(fine, file);
  }

 private:
  template <class T>
  void write_as(const Frame& frame, const std::filesystem::path& file) const {
    DeviceSet devices = host_devices(1);
    const Store<T> store(level_.scene, devices);
    StateSnapshot<T> state = store.snapshot();
    const auto positions = of(frame.cloth_positions);
    const auto velocities = of(frame.cloth_velocities);
    for (std::size_t i = 0; i < positions.size(); ++i) {
      const auto v = static_cast<std::size_t>(store.model().to_internal[i]);
      state.positions[v] = vec_cast<T>(positions[i]);
      state.velocities[v] = vec_cast<T>(velocities[i]);
    }
    state.time = frame.time;
    write_checkpoint(file, level_.scene, store.model(), state, Sewing{});
  }

  const CoarseScene& level_;
  Eigen::SparseMatrix<double> sums_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factors_;
};

}  // namespace weft::bench
