#include "host/app/run/number_range.hpp"

#include <cmath>
#include <string>

#include "host/input/quantity.hpp"
#include "host/input/safe_text.hpp"

namespace weft::app {
namespace {

/// @param allowed description of the range
CLI::Validator range(double low, double high, bool whole, const std::string& allowed) {
  return {[=](const std::string& text) -> std::string {
            double value = 0;
            const bool good = CLI::detail::lexical_cast(text, value) && value >= low &&
                              value <= high && (!whole || value == std::floor(value));
            return good ? "" : quoted_start(text) + "; allowed: " + allowed;
          },
          ""};
}

}  // namespace

CLI::Validator number_range(double low, double high) {
  return range(low, high, false,
               "a number from " + short_number(low) + " to " + short_number(high));
}

CLI::Validator whole_number_range(int low, int high) {
  return range(low, high, true,
               "an integer from " + std::to_string(low) + " to " + std::to_string(high));
}

}  // namespace weft::app
