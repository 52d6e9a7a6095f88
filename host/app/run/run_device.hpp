#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "host/app/run/run_request.hpp"
#include "host/io/scene/scene_file.hpp"
#include "weft/devices.hpp"

namespace weft::app {

/// Where a run takes place.
struct RunDevice {
  std::string text;                      ///< such as "cpu:2" or "cuda:0,1"
  std::optional<DeviceChoice> choice{};  ///< of "auto"
};

/// What `--device` says; else where the run took place that is resumed, so that it goes on with the
/// same bits; else what the scene says; "auto" is decided here.
/// @param output directory of the run
/// @throws SceneError  if the text means nothing
/// @throws DeviceError if a GPU cannot be measured
RunDevice device_of(const RunRequest& request, const io::SceneFile& file,
                    const std::string& output);

/// A choice and what it rests on: of report.json, and of what `weft plan` writes.
nlohmann::ordered_json choice_json(const DeviceChoice& choice);

/// Prints what was chosen and why; with `all` also what was measured.
void print_choice(const DeviceChoice& choice, bool all);

}  // namespace weft::app
