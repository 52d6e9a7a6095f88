#pragma once

#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "host/implicit/linear_system.hpp"
#include "host/scene/procedural.hpp"

namespace weft {

/// A square sheet of 2 m in the air, cells x cells quads of alternating diagonals, one corner
/// pinned, wavy and strained by some percent; fabric "stiff" of the drape benchmark, steps of 5 ms.
inline Scene wavy_sheet(Index cells) {
  Scene scene;
  scene.name = "wavy sheet";
  Material fabric;
  fabric.name = "stiff";
  fabric.density = 0.2;
  fabric.stretch_stiffness = 1000;
  fabric.poisson_ratio = 0.35;
  fabric.bending_stiffness = 1e-5;
  scene.materials = {fabric};
  Cloth cloth;
  cloth.name = "sheet";
  cloth.mesh = make_grid({2, 2}, {cells, cells}, Diagonals::alternating);
  for (Vec3<double>& x : cloth.mesh.positions)
    x = {x[0] * (1 + 0.02 * std::sin(5 * x[1])), x[1] * (1 + 0.01 * std::sin(7 * x[0])),
         0.03 * std::sin(9 * x[0]) * std::sin(8 * x[1])};
  scene.cloths = {cloth};
  Pin corner;
  corner.vertices = {0};
  scene.pins = {corner};
  scene.time.step = 0.005;
  return scene;
}

/// The linear system of a scene's first step, without contacts, and all that it needs.
template <class T>
class FirstSystem {
 public:
  FirstSystem(const Scene& scene, DeviceSet devices)
      : scene_(scene), devices_(std::move(devices)), store_(scene_, devices_) {
    for (int r = 0; r < devices_.size(); ++r) {
      geometry_.push_back(make_geometry(store_, r));
      motion_.push_back(make_motion(store_, r));
    }
    system_ = std::make_unique<LinearSystem<T>>(store_, geometry_, motion_);
    for (int r = 0; r < devices_.size(); ++r) {
      Queue& queue = devices_[r].compute();
      const RankState<T>& state = store_.rank(r);
      RankMotion<T>& motion = motion_[static_cast<std::size_t>(r)];
      for (Buffer<Vec3<T>>* positions :
           {&motion.base_positions, &motion.positions_t1, &system_->iterate_positions(r)})
        queue.copy(positions->data(), state.positions.data(), positions->size() * sizeof(Vec3<T>));
      queue.copy(motion.base_velocities.data(), state.velocities.data(),
                 motion.base_velocities.size() * sizeof(Vec3<T>));
    }
    sync();
  }

  /// Submits the assembly, preconditioner and first guess included.
  void assemble() {
    system_->assemble(at(), [](int) { return Span<const Contact<T>>(); });
  }
  /// Submits the solve of the assembled system.
  void solve() { system_->launch_solve(at(), 0); }
  void sync() {
    for (int r = 0; r < devices_.size(); ++r) devices_[r].compute().sync();
  }
  SolveStatus status() { return system_->status(); }
  /// Own rows of all ranks, of v_k + dv. [m/s]
  std::vector<Vec3<T>> velocities() {
    std::vector<Vec3<T>> all;
    for (int r = 0; r < devices_.size(); ++r) {
      const auto own =
          download(devices_[r].compute(), motion_[static_cast<std::size_t>(r)].velocities_t1);
      const auto n = static_cast<std::size_t>(r);
      all.insert(all.end(), own.begin() + store_.partition().row_begin[n],
                 own.begin() + store_.partition().row_begin[n + 1]);
    }
    return all;
  }
  /// What the solves from now on are to do.
  SolverSettings& settings() { return scene_.solver; }
  const Store<T>& store() const { return store_; }

 private:
  Linearisation at() const { return {scene_.time.step, true, true, true}; }

  Scene scene_;
  DeviceSet devices_;
  Store<T> store_;
  std::vector<RankGeometry<T>> geometry_;
  std::vector<RankMotion<T>> motion_;
  std::unique_ptr<LinearSystem<T>> system_;
};

}  // namespace weft
