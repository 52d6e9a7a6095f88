#pragma once

#include <memory>
#include <variant>

#include "host/implicit/step.hpp"
#include "host/scene/seams/sewing.hpp"
#include "host/simulation/cloth_positions.hpp"
#include "host/simulation/frame_clock.hpp"
#include "host/state/progress_board.hpp"
#include "host/state/store.hpp"

namespace weft {

/// State and method in one precision.
template <class T>
struct Run {
  Store<T> store;
  std::unique_ptr<ImplicitStep<T>> implicit;  ///< null with the method asynchronous
  std::unique_ptr<StepMethod> other;          ///< in its place, or around it where cloth may sleep
  ClothPositions<T> positions{store};

  /// @param scene  must outlive this
  /// @param before see Store
  Run(const Scene& scene, DeviceSet& devices, const Sewing& sewing, const Run* before = nullptr);

  /// Advances by one step, whose length is that of the scene or the frame, or what its error
  /// allows. A step that fails leaves the state as it was.
  /// @param report its number is set
  void step(const FrameClock& clock, StepReport& report, ProgressBoard& board);

 private:
  StepMethod& method() { return other ? *other : *implicit; }
  /// Whether cloth may sleep.
  bool sleeps() const { return implicit && other; }
  void advance(double dt, StepReport& report, ProgressBoard& board);
  void step_fixed(const FrameClock& clock, StepReport& report, ProgressBoard& board);
  void step_automatic(const FrameClock& clock, StepReport& report, ProgressBoard& board);
};

using Runs =
    std::variant<std::monostate, std::unique_ptr<Run<float>>, std::unique_ptr<Run<double>>>;

}  // namespace weft
