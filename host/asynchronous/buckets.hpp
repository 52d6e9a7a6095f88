#pragma once

#include <cstdint>
#include <vector>

#include "host/asynchronous/clock.hpp"
#include "host/asynchronous/driven.hpp"
#include "host/asynchronous/histories.hpp"
#include "host/asynchronous/layers.hpp"
#include "host/asynchronous/prescribed.hpp"
#include "host/asynchronous/sheet.hpp"
#include "host/asynchronous/worker_group.hpp"
#include "weft/scene.hpp"

namespace weft {

/// A window that is simulated: where all vertices are, how they came there, and the layers that
/// act.
struct WindowState {
  VertexMotion motion;
  Histories trajectories;
  ActiveLayers layers;
  std::size_t phase = 0;  ///< release times that have passed

  std::size_t bytes() const { return motion.bytes() + trajectories.bytes() + layers.bytes(); }
};

/// What one simulation of a window did.
struct Pass {
  std::int64_t ticks = 0, elements = 0, pairs = 0, acting = 0;
  double time = 0;        ///< [s] in all
  double layer_time = 0;  ///< [s] in layers
  bool stopped = false;   ///< not to the end
};

/// All forces of a scene, in buckets that tick at a step of their own. One simulation at a time.
class ForceBuckets {
 public:
  /// @param place [vertices of the model] their numbers in VertexMotion @param order the other way
  ///              round
  /// @param scene, model must outlive this
  /// @throws SceneError if the step that forces ask for is below method.asynchronous.smallest_step
  ForceBuckets(const Scene& scene, const Model& model, const std::vector<Index>& place,
               const std::vector<Index>& order);

  const LayerRule& rule() const { return forces_.rule; }
  double internal_step() const { return internal_step_; }  ///< [s]
  const DrivenBodies& bodies() const { return bodies_; }

  /// Starts the prescribed motion, unless its first tick has passed.
  void begin(double time, WindowState& course);

  /// Processes all ticks of [from, to).
  Pass simulate(double from, double to, WindowState& course, const WorkerGroup& group);

 private:
  /// In the order of ticks at one time: bodies take what the cloth has just given them.
  enum Bucket : int { prescribed, gravity, internal, driven_bodies, first_layer };

  Ticks ticks_of(int bucket) const;
  void process(const Tick& tick, WindowState& course, Workers& workers, Pass& pass);
  void advance_cloth(double time, WindowState& course, Workers& workers) const;

  const Scene& scene_;
  std::size_t cloth_count_;
  Sheet sheet_;
  Prescribed prescribed_;
  DrivenBodies bodies_;
  LayerForces forces_;
  std::vector<PlateMatrix> plates_;  ///< [release times + 1]
  double internal_step_ = 0;         ///< [s]
};

}  // namespace weft
