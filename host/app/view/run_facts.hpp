#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

#include "host/app/run/step_log.hpp"

namespace weft::app {

/// Names of the values of step_facts().
nlohmann::ordered_json step_fields();

/// What the player says of a step.
nlohmann::ordered_json step_facts(const StepLine& line);

/// What the player says of a run beside its frames, from report.json and steps.jsonl: as much as
/// there is and can be read. Only values of the expected types are taken: a stranger may have
/// written the files.
/// @param directory of a run; anything else has no facts
/// @return an object; "steps" has a list per step, in the order of "step_fields"
nlohmann::ordered_json run_facts(const std::filesystem::path& directory);

}  // namespace weft::app
