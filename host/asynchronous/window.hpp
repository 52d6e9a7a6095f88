#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/asynchronous/buckets.hpp"
#include "host/asynchronous/detection.hpp"
#include "host/asynchronous/start_record.hpp"
#include "host/asynchronous/tuner.hpp"
#include "weft/report.hpp"
#include "weft/scene.hpp"

namespace weft {

/// Time and state of an asynchronous simulation, and how it goes on by windows.
class Windows {
 public:
  /// @param scene, model must outlive this
  /// @throws SceneError if the step that forces ask for is below method.asynchronous.smallest_step
  /// @param stop once true, advance() fails soon with Failure::stopped; null: never
  Windows(const Scene& scene, const Model& model, int threads,
          const std::atomic<bool>* stop = nullptr);

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
  std::vector<double> driven() const { return DrivenBodies::state_of(now_.motion); }

  /// What windows take, and what those take beside it that are begun while the last one is looked
  /// at.
  struct Memory {
    std::size_t now = 0, ahead = 0;  ///< [bytes]
  };
  Memory memory() const;

  double time() const { return time_; }  ///< [s]
  /// [vertices of the model] their numbers here, in VertexMotion and Histories
  const std::vector<Index>& places() const { return place_; }
  const LayerRule& rule() const { return buckets_.rule(); }
  double internal_step() const { return buckets_.internal_step(); }  ///< [s]

  /// Called with the histories of each accepted window, for tests.
  using Observer = void (*)(void* context, const Histories& trajectories,
                            const ActiveLayers& layers, const VertexMotion& motion,
                            const LayerRule& rule);
  void observe(Observer observer, void* context) {
    observer_ = observer;
    context_ = context;
  }

 private:
  /// What a detection found.
  struct Look {
    std::vector<PrimitivePair> missed, expected;
    DetectionCounts counts;
    double time = 0;       ///< [s] of detection
    double over = 0;       ///< [s] that the next window's begin took longer
    bool went_on = false;  ///< the next window has been simulated meanwhile, and that stands

    bool clear() const { return missed.empty() && expected.empty(); }
  };

  /// What it takes to begin the next window while the last one is looked at.
  struct Ahead {
    Workers both{2};  ///< one for each
    Workers looking;  ///< half of the threads each
    Workers going;
    WindowState course;
    Pass pass;
    explicit Ahead(int threads) : looking(threads - threads / 2), going(threads / 2) {}
  };

  bool window(double from, double to, double after, StepReport& report);
  void detect(const WorkerGroup& group, std::atomic<bool>& found, Look& look);
  void detect_and_go_on(double to, double after, Look& look);
  void look_at(double to, double after, Look& look, AsynchronousCounts& counts);
  void book(const Look& look, AsynchronousCounts& counts) const;
  void book_ahead(const Look& look, AsynchronousCounts& counts);
  static void accept(const Pass& pass, AsynchronousCounts& counts);
  void deepen_expected(std::vector<PrimitivePair> pairs);
  bool deepen(const std::vector<PrimitivePair>& missed, StepReport& report);
  bool fail(StepReport& report, Failure failure, const std::string& detail) const;
  bool finite() const;

  const Scene& scene_;
  const Model& model_;
  const std::atomic<bool>* stop_;
  AsynchronousSettings settings_;
  Workers workers_;
  std::vector<Index> order_, place_;
  ForceBuckets buckets_;
  Detection detection_;
  WindowState now_;
  VertexMotion saved_;  ///< as a window began
  std::size_t saved_phase_ = 0;
  std::optional<Ahead> ahead_;  ///< if windows are begun so
  StartRecord record_;          ///< of what detections found
  bool begun_ = false;          ///< now_ has gone through the next window already
  double time_ = 0;
  WindowTuner tuner_;
  std::vector<Vec3<double>> finished_x_, finished_v_;  ///< as finish() gave them
  Observer observer_ = nullptr;
  void* context_ = nullptr;
};

}  // namespace weft
