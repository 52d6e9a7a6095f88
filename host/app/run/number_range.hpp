#pragma once

#include <CLI/CLI.hpp>

namespace weft::app {

/// Check of an option's number, whose message names the value and what is allowed.
CLI::Validator number_range(double low, double high);

/// The same for whole numbers.
CLI::Validator whole_number_range(int low, int high);

}  // namespace weft::app
