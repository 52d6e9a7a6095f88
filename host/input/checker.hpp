#pragma once

#include <charconv>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>

#include "host/input/quantity.hpp"
#include "weft/core/vec.hpp"
#include "weft/error.hpp"

namespace weft {

/// The shortest text that says exactly this number.
inline std::string text_of(double value) {
  char buffer[32];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, value).ptr;
  return {buffer, end};
}

/// Such as "cloths[2]".
inline std::string numbered(const char* array, std::size_t i) {
  return std::string(array) + "[" + std::to_string(i) + "]";
}

/// Range checks with one place for file and the path of the part being looked at. What fails is
/// refused by SceneError with the file, the path of the field, the value and what is allowed.
class Checker {
 public:
  /// @param file   kept by reference; empty: the scene was not read from one
  /// @param prefix path of the part, without the dot at its end
  Checker(const std::string& file, std::string prefix) : file_(file), prefix_(std::move(prefix)) {}

  /// @throws SceneError always
  [[noreturn]] void refuse(const std::string& field, const std::string& value,
                           const std::string& allowed) const {
    throw SceneError(file_, prefix_.empty() ? field : prefix_ + "." + field, value, allowed);
  }
  /// @throws SceneError unless `good` and the value is finite; so do those below
  void require(bool good, const char* field, double value, const char* allowed) const {
    // A comparison with NaN is false, so that ranges written as "good" refuse it; infinities are
    // refused here.
    if (!good || !std::isfinite(value)) refuse(field, text_of(value), allowed);
  }
  void within(const std::string& field, double value, const Quantity& kind) const {
    if (!kind.holds(value)) refuse(field, text_of(value), kind.allowed());
  }
  /// @throws SceneError with the number of the component that is out of range
  void within(const std::string& field, const Vec3<double>& value, const Quantity& kind) const {
    for (int k = 0; k < 3; ++k) within(field + "[" + std::to_string(k) + "]", value[k], kind);
  }
  void integer(const char* field, int value, int low, int high) const {
    if (value < low || value > high)
      refuse(field, std::to_string(value),
             "an integer from " + std::to_string(low) + " to " + std::to_string(high));
  }

 private:
  const std::string& file_;
  std::string prefix_;
};

}  // namespace weft
