#pragma once

#include <nlohmann/json.hpp>

#include "weft/report.hpp"

namespace weft::app {

/// Of a step or, summed up, of a run.
nlohmann::ordered_json balance_json(const BalanceReport& balance);

/// What balance_json() made of a step.
/// @throws nlohmann::json::exception if it is none of ours
BalanceReport parse_balance(const nlohmann::ordered_json& json);

}  // namespace weft::app
