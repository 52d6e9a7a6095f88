#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/asynchronous/clock.hpp"
#include "host/asynchronous/detection.hpp"
#include "host/asynchronous/driven.hpp"
#include "host/asynchronous/layers.hpp"
#include "host/asynchronous/prescribed.hpp"
#include "host/asynchronous/sheet.hpp"
#include "host/asynchronous/tuner.hpp"
#include "weft/report.hpp"
#include "weft/scene.hpp"

namespace weft {

/// Time and state of an asynchronous simulation, and how it goes on by windows.
class Windows {
 public:
  /// @param scene, model must outlive this
  /// @throws SceneError if the step that forces ask for is below method.asynchronous.smallest_step
  Windows(const Scene& scene, const Model& model, int threads);

  /// Takes over a state.
  /// @param positions  [vertices] [m] @param velocities [cloth vertices] [m/s], of the model
  /// @param driven     as DrivenBodies::begin()
  void start(const std::vector<Vec3<double>>& positions,
             const std::vector<Vec3<double>>& velocities, double time,
             const std::vector<double>& driven = {});

  /// Goes on to `end` through windows.
  /// @return false if a cap was reached or the state is not finite: report says which, and the
  ///         state is of no use
  bool advance(double end, StepReport& report);

  /// The state at the time that advance() went to, in the order of the model.
  void finish(std::vector<Vec3<double>>& positions, std::vector<Vec3<double>>& velocities);

  /// State of the driven bodies likewise.
  std::vector<double> driven() const { return DrivenBodies::state_of(motion_); }

  double time() const { return time_; }  ///< [s]
  /// [vertices of the model] their numbers here, in VertexMotion and Histories
  const std::vector<Index>& places() const { return place_; }
  const LayerRule& rule() const { return forces_.rule; }
  double internal_step() const { return internal_step_; }  ///< [s]

  /// Called with the histories of each accepted window, for tests.
  using Observer = void (*)(void* context, const Histories& ways, const ActiveLayers& layers,
                            const VertexMotion& motion, const LayerRule& rule);
  void observe(Observer observer, void* context) {
    observer_ = observer;
    context_ = context;
  }

 private:
  /// In the order of ticks at one time: bodies take what the cloth has just given them.
  enum Bucket : int { prescribed, gravity, internal, driven_bodies, first_layer };

  /// What one simulation of a window did.
  struct Pass {
    std::int64_t ticks = 0, elements = 0, pairs = 0, acting = 0;
    double time = 0;        ///< [s] in all
    double layer_time = 0;  ///< [s] in layers
  };

  bool window(double from, double to, StepReport& report);
  Pass simulate(double from, double to);
  void process(const Tick& tick, Pass& pass);
  static void accept(const Pass& pass, AsynchronousCounts& counts);
  Ticks ticks_of(int bucket) const;
  void advance_cloth(double time);
  void deepen_expected(std::vector<PrimitivePair> pairs);
  bool deepen(const std::vector<PrimitivePair>& missed, StepReport& report);
  bool fail(StepReport& report, Failure failure, const std::string& detail) const;
  bool finite() const;

  const Scene& scene_;
  const Model& model_;
  AsynchronousSettings settings_;
  Workers workers_;
  std::vector<Index> order_, place_;
  Sheet sheet_;
  Prescribed prescribed_;
  DrivenBodies bodies_;
  Detection detection_;
  LayerForces forces_;
  ActiveLayers layers_;
  VertexMotion motion_, saved_;
  Histories ways_;
  double time_ = 0;
  std::vector<PlateMatrix> plates_;  ///< [release times + 1]
  std::size_t phase_ = 0;            ///< into plates_
  WindowTuner tuner_;
  double internal_step_ = 0;                           ///< [s]
  std::vector<Vec3<double>> finished_x_, finished_v_;  ///< as finish() gave them
  Observer observer_ = nullptr;
  void* context_ = nullptr;
};

}  // namespace weft
