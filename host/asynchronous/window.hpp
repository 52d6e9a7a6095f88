#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/asynchronous/buckets.hpp"
#include "host/asynchronous/detection.hpp"
#include "host/asynchronous/start_record.hpp"
#include "weft/report.hpp"
#include "weft/scene.hpp"

namespace weft {

/// An asynchronous simulation: its time, its state, and the loop over windows.
class Windows {
 public:
  /// @param scene, model must outlive this
  /// @throws SceneError if forces need a step below method.asynchronous.smallest_step
  /// @param stop once true, advance() fails soon with Failure::stopped; null: never
  Windows(const Scene& scene, const Model& model, int threads,
          const std::atomic<bool>* stop = nullptr);

  /// Starts from a state.
  /// @param positions  [vertices] [m] in the order of the model
  /// @param velocities [cloth vertices] [m/s] in the order of the model
  /// @param driven     see DrivenBodies::begin()
  /// @param finished   the state is the one that finish() returned last, whose layers are known
  void start(const std::vector<Vec3<double>>& positions,
             const std::vector<Vec3<double>>& velocities, double time,
             const std::vector<double>& driven = {}, bool finished = false);

  /// Simulates windows up to the time `end`.
  /// @return false if a limit of the scene was reached, the state is not finite, or a stop was
  ///         requested. The report gives the reason, and the state must not be used.
  bool advance(double end, StepReport& report);

  /// The state at the time that advance() reached, in the order of the model.
  void finish(std::vector<Vec3<double>>& positions, std::vector<Vec3<double>>& velocities);

  /// State of the driven bodies at that time.
  std::vector<double> driven() const { return DrivenBodies::state_of(now_.motion); }

  /// Memory of the current window, and of the next one if it may begin during detection.
  struct Memory {
    std::size_t now = 0, ahead = 0;  ///< [bytes]
  };
  Memory memory() const;

  double time() const { return time_; }  ///< [s]
  /// [vertices of the model] their numbers in VertexMotion and Histories
  const std::vector<Index>& places() const { return place_; }
  const LayerRule& rule() const { return buckets_.rule(); }
  double internal_step() const { return buckets_.internal_step(); }  ///< [s]

  /// Called with the trajectories of each accepted window, for tests.
  using Observer = void (*)(void* context, const Histories& trajectories,
                            const ActiveLayers& layers, const VertexMotion& motion,
                            const LayerRule& rule);
  void observe(Observer observer, void* context) {
    observer_ = observer;
    context_ = context;
  }

 private:
  /// Result of one detection.
  struct Look {
    std::vector<PrimitivePair> missed, expected;
    DetectionCounts counts;
    double time = 0;       ///< [s] of detection
    double over = 0;       ///< [s] that the next window took longer than detection
    bool went_on = false;  ///< the next window was simulated at the same time, and is valid

    bool clear() const { return missed.empty() && expected.empty(); }
  };

  /// Threads and state for simulating the next window during detection.
  struct Ahead {
    Workers both{2};  ///< one thread for detection, one for the next window
    Workers looking;  ///< threads of detection: half of all
    Workers going;    ///< threads of the next window: the other half
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
  bool fail(StepReport& report, Failure failure, const std::string& detail,
            const std::optional<Vec3<double>>& place = {}) const;
  Vec3<double> place_of(const PrimitivePair& pair) const;
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
  VertexMotion saved_;  ///< state at the start of the window
  std::size_t saved_phase_ = 0;
  std::optional<Ahead> ahead_;  ///< none if windows never begin during detection
  StartRecord record_;          ///< decides whether that is worthwhile
  bool begun_ = false;          ///< now_ is already at the end of the next window
  double time_ = 0;
  Observer observer_ = nullptr;
  void* context_ = nullptr;
};

}  // namespace weft
