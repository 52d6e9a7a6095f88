#pragma once

#include <memory>

namespace weft {

class Simulation;
struct Tracking;

/// What the engine's own parts do with a simulation, and programs do not.
struct SimulationAccess {
  /// From now on, steps of the method "implicit" hold averages over parts of the cloth at the
  /// targets in `tracking`. This ends when seams are welded or meshes change. Null: no tracking.
  /// @throws DeviceError unless there is a single rank, on the host
  static void track(Simulation& simulation, const std::shared_ptr<const Tracking>& tracking);
};

}  // namespace weft
