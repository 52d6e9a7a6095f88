#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "host/implicit/linear/linear_system.hpp"
#include "weft/shapes.hpp"

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

/// Contacts of every third vertex with three that are half of all vertices further on, as if the
/// sheet lay folded; as stiff as the step makes them.
/// @param mass [kg] of a vertex   @param step [s]
template <class T>
std::vector<Contact<T>> folded_contacts(Index vertices, double mass, double step) {
  std::vector<Contact<T>> all;
  for (Index v = 0; v < vertices; v += 3) {
    const Index other = (v + vertices / 2) % (vertices - 2);
    Contact<T> c{};
    c.v[0] = v;
    c.w[0] = T(1);
    for (Index j = 1; j < 4; ++j) {
      c.v[j] = other + j - 1;
      c.w[j] = j == 1 ? T(-0.5) : T(-0.25);
    }
    c.n = {T(0.6), T(0), T(0.8)};
    c.stiffness = c.hold = static_cast<T>(10 * mass / (step * step));
    c.thickness = T(0.001);
    c.friction = T(0.1);
    c.push = c.stiffness;
    c.drag = T(0.1) * c.stiffness;
    all.push_back(c);
  }
  return all;
}

/// The linear system of a scene's first step, and all that it needs.
template <class T>
class FirstSystem {
 public:
  /// @param folded with folded_contacts(), instead of without any
  FirstSystem(const Scene& scene, DeviceSet devices, bool folded = false)
      : scene_(scene),
        devices_(std::move(devices)),
        store_(scene_, devices_),
        geometry_(make_geometry(store_)) {
    for (int r = 0; r < devices_.size(); ++r) {
      motion_.push_back(make_motion(store_, r));
      contacts_.emplace_back(devices_[r]);
    }
    if (folded) set_contacts(all_contacts());
    system_ = std::make_unique<LinearSystem<T>>(store_, geometry_, motion_);
    for (int r = 0; r < devices_.size(); ++r) {
      Queue& queue = devices_[r].compute();
      const RankState<T>& state = store_.rank(r);
      RankMotion<T>& motion = motion_[static_cast<std::size_t>(r)];
      for (Buffer<Vec3<T>>* positions :
           {&motion.base_positions, &motion.positions_t1, &system_->iterate_positions(r),
            &system_->moving_frame(r).positions})
        queue.copy(positions->data(), state.positions.data(), positions->size() * sizeof(Vec3<T>));
      queue.copy(motion.base_velocities.data(), state.velocities.data(),
                 motion.base_velocities.size() * sizeof(Vec3<T>));
      Buffer<Vec3<T>>& turned = system_->moving_frame(r).velocities;
      queue.copy(turned.data(), state.velocities.data(), turned.size() * sizeof(Vec3<T>));
      Buffer<Vec3<T>>& velocities = system_->iterate_velocities(r);
      queue.fill(velocities.data(), 0, velocities.size() * sizeof(Vec3<T>));
      queue.fill(system_->moving_frame(r).turned.data(), 0, sizeof(std::int32_t));
    }
    sync();
  }

  /// All folded_contacts() of the scene.
  std::vector<Contact<T>> all_contacts() const {
    return folded_contacts<T>(store_.model().cloth_vertex_count, store_.model().mass[0],
                              scene_.time.step);
  }
  /// Contacts of the systems assembled from now on. Waits for the devices.
  void set_contacts(const std::vector<Contact<T>>& contacts) {
    for (int r = 0; r < devices_.size(); ++r) {
      Queue& queue = devices_[r].compute();
      queue.sync();
      upload(queue, contacts_[static_cast<std::size_t>(r)], contacts);
    }
  }

  /// Submits the assembly, preconditioner and initial guess included.
  void assemble() {
    system_->assemble(at(), [this](int r) {
      return Span<const Contact<T>>(contacts_[static_cast<std::size_t>(r)].span());
    });
  }
  /// Submits the solve of the assembled system.
  void solve() { system_->launch_solve(at(), {}); }
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
  /// Most memory that a rank has held so far [bytes].
  std::size_t peak_bytes() const {
    std::size_t peak = 0;
    for (int r = 0; r < devices_.size(); ++r) peak = std::max(peak, devices_[r].peak_bytes());
    return peak;
  }
  /// See LinearSystem.
  void gather_before_products(bool gather) { system_->gather_before_products(gather); }
  /// By rank and use.
  std::vector<std::vector<MemoryUse>> memory_use() const {
    std::vector<std::vector<MemoryUse>> uses;
    for (int r = 0; r < devices_.size(); ++r) uses.push_back(devices_[r].memory_use());
    return uses;
  }
  /// What the solves from now on are to do.
  SolverSettings& settings() { return scene_.solver; }
  const Store<T>& store() const { return store_; }
  /// Of rank 0.
  Device& device() { return devices_[0]; }

 private:
  Linearisation at() const {
    return {.h = scene_.time.step, .moved = true, .without_rates = true, .predicted = true};
  }

  Scene scene_;
  DeviceSet devices_;
  Store<T> store_;
  std::vector<RankGeometry<T>> geometry_;
  std::vector<RankMotion<T>> motion_;
  std::vector<Buffer<Contact<T>>> contacts_;
  std::unique_ptr<LinearSystem<T>> system_;
};

}  // namespace weft
