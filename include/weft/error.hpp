#pragma once

#include <stdexcept>
#include <string>

namespace weft {

/// The input is wrong: a scene, a parameter, a mesh or a checkpoint. The message is one line that
/// names the file, the field, the value and the allowed values.
class SceneError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
  /// @param file    file that holds the value; empty for a scene made in memory
  /// @param field   path of the field, such as "cloths[0].grid.size"
  /// @param value   the offending value, or what is wrong, such as "missing" or "no vertices"
  /// @param allowed description of the accepted values
  SceneError(const std::string& file, const std::string& field, const std::string& value,
             const std::string& allowed)
      : std::runtime_error((file.empty() ? std::string() : file + ": ") + field + ": " + value +
                           "; allowed: " + allowed) {}
};

/// A device is missing, lost, out of memory, or cannot do what was asked.
class DeviceError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The simulation could not continue: no convergence, a NaN, or an intersection that could not be
/// resolved. Thrown only by calls that simulate a whole frame or run; a step reports instead.
class SimulationError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The setup of a simulation was interrupted, see DeviceSet::stop_on(). A step reports
/// Failure::stopped instead.
class StoppedError : public std::runtime_error {
 public:
  StoppedError() : std::runtime_error("stopped") {}
};

}  // namespace weft
