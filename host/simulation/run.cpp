#include "host/simulation/run.hpp"

#include <optional>
#include <type_traits>

#include "host/asynchronous/step.hpp"
#include "host/implicit/sleep/sleeping_step.hpp"

namespace weft {

template <class T>
Run<T>::Run(const Scene& scene, DeviceSet& devices, const Sewing& sewing, const Run* before)
    : store(scene, devices, sewing.welded, before != nullptr ? &before->store : nullptr) {
  if constexpr (std::is_same_v<T, double>)
    if (scene.method == "asynchronous") {
      other = std::make_unique<AsynchronousStep>(store);
      return;
    }
  implicit = std::make_unique<ImplicitStep<T>>(
      store, before != nullptr ? before->implicit.get() : nullptr);
  if (scene.implicit.sleep_distance > 0)
    other = std::make_unique<SleepingStep<T>>(store, *implicit);
}

template <class T>
void Run<T>::advance(double dt, StepReport& report, ProgressBoard& board) {
  method().publish_on(board);
  method().advance(dt, report);
}

template <class T>
void Run<T>::step(const FrameClock& clock, StepReport& report, ProgressBoard& board) {
  if (clock.automatic())
    step_automatic(clock, report, board);
  else
    step_fixed(clock, report, board);
}

template <class T>
void Run<T>::step_fixed(const FrameClock& clock, StepReport& report, ProgressBoard& board) {
  const FrameClock::FixedStep step = clock.next_fixed(report.number, store.time);
  report.step = step.length;
  // Pieces fall asleep and wake while a step is tried. Other steps go back by themselves.
  std::optional<StateSnapshot<T>> start;
  if (sleeps()) start = store.snapshot();
  advance(step.length, report, board);
  if (report.failure != Failure::none && start) store.restore(*start);
  if (report.failure == Failure::none) store.time = step.end;
}

/// Attempts that are too long are taken back.
template <class T>
void Run<T>::step_automatic(const FrameClock& clock, StepReport& report, ProgressBoard& board) {
  const StepControl& control = clock.step_control();
  const Backoff backoff = store.backoff;
  double wanted = store.next_step;
  // The last attempt is taken whatever its error is.
  for (int attempt = 0; attempt <= StepControl::rejections_max; ++attempt) {
    const StepControl::Step step = control.next(wanted, store.time);
    report.step = step.length;
    store.keep();
    advance(step.length, report, board);
    if (report.failure != Failure::none) return;
    const double error = *report.step_error;
    // A step that was bisected has been taken in shorter parts already.
    const bool whole = report.fallback_level == FallbackLevel::whole;
    if (!whole || !control.rejects(step, error, attempt)) {
      store.next_step = control.after(step, error, whole && attempt == 0);
      store.time = step.end;
      return;
    }
    store.go_back();
    store.backoff = backoff;
    wanted = control.again(step, error);
    ++report.rejected;
    report.compliant = 0;
    report.compliance_distance = 0;
  }
}

template struct Run<float>;
template struct Run<double>;

}  // namespace weft
