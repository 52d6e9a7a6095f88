#include "host/asynchronous/step.hpp"

#include <utility>

namespace weft {

AsynchronousStep::AsynchronousStep(Store<double>& store)
    : store_(store),
      windows_(store.scene(), store.model(), store.devices().size(), store.devices().stop_flag()) {}

AsynchronousStep::~AsynchronousStep() {
  MemoryBook& book = store_.devices()[0].memory();
  book.remove("windows", booked_.now);
  book.remove("windows_ahead", booked_.ahead);
}

/// Which grows only: windows keep their lists.
void AsynchronousStep::book_memory() {
  MemoryBook& book = store_.devices()[0].memory();
  const Windows::Memory memory = windows_.memory();
  const auto grow = [&](const char* name, std::size_t& booked, std::size_t bytes) {
    if (bytes <= booked) return;
    book.add(name, bytes - booked);
    booked = bytes;
  };
  grow("windows", booked_.now, memory.now);
  grow("windows_ahead", booked_.ahead, memory.ahead);
}

void AsynchronousStep::advance(double dt, StepReport& report) {
  if (board_ != nullptr) board_->enter(StepStage::windows);
  StateSnapshot<double> state = store_.snapshot();
  const bool own = store_.restores() == std::exchange(own_restore_, -1);
  windows_.start(state.positions, state.velocities, state.time, state.driven, own);
  // The time that the simulation will say it is, to the bit: no tick may be lost or done twice.
  const bool good = windows_.advance(static_cast<double>(report.number) * dt, report);
  book_memory();
  if (!good) {
    report.fallback_level = FallbackLevel::failed;
    return;
  }
  std::vector<Vec3<double>> positions = state.positions;
  std::vector<Vec3<double>> velocities = state.velocities;
  windows_.finish(positions, velocities);
  state.previous_positions = std::exchange(state.positions, std::move(positions));
  state.previous_velocities = std::exchange(state.velocities, std::move(velocities));
  state.driven = windows_.driven();
  state.previous_step = dt;
  state.time = windows_.time();
  const AsynchronousCounts& counts = report.asynchronous;
  report.stages.contacts += counts.detection;
  report.stages.solve += counts.useful + counts.unneeded + counts.resimulation;
  report.stages.other += counts.bookkeeping;
  store_.restore(state);
  own_restore_ = store_.restores();
}

}  // namespace weft
