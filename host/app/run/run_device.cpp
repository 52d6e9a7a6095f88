#include "host/app/run/run_device.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "host/app/process/show.hpp"
#include "host/app/run/run_directory.hpp"
#include "host/app/run/run_report.hpp"
#include "host/base/file_bytes.hpp"
#include "host/exec/device_text.hpp"

namespace weft::app {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// Device of the run that left `scene`, its resolved scene; empty if that does not say.
std::string recorded_device(const fs::path& scene) {
  const Json json = Json::parse(bytes_if_readable(scene), nullptr, false);
  if (!json.is_object() || !json.contains("device") || !json["device"].is_string()) return {};
  return json["device"].get<std::string>();
}

std::string asked_device(const RunRequest& request, const io::SceneFile& file,
                         const std::string& output) {
  if (!request.device.empty()) return request.device;
  if (!request.resume.empty()) {
    const fs::path from =
        request.resume == "latest" ? fs::path(output) : fs::absolute(request.resume).parent_path();
    const std::string recorded = recorded_device(RunDirectory(from).scene());
    if (!recorded.empty()) return recorded;
  }
  return file.device;
}

}  // namespace

RunDevice device_of(const RunRequest& request, const io::SceneFile& file,
                    const std::string& output) {
  const DeviceText asked = read_device_text(asked_device(request, file, output));
  if (!asked.automatic) return {asked.text()};
  DeviceChoice choice = choose_devices(file.scene);
  return {choice.device, std::move(choice)};
}

Json choice_json(const DeviceChoice& choice) {
  Json estimates = Json::array();
  for (const DeviceEstimate& e : choice.estimates)
    estimates.push_back(
        {{"gpus", e.gpus}, {"transport", e.transport}, {"step_ms", 1e3 * e.seconds}});
  return {{"device", choice.device.empty() ? Json(nullptr) : Json(choice.device)},
          {"reason", choice.reason},
          {"estimates", estimates},
          {"figures", choice.figures}};
}

void print_choice(const DeviceChoice& choice, bool all) {
  if (choice.device.empty()) {
    show(stdout, "--device auto: error: {}\n", choice.reason);
    return;
  }
  show(stdout, "--device auto: {}; {}\n", choice.device, choice.reason);
  if (!all) return;
  for (const DeviceEstimate& e : choice.estimates)
    show(stdout, "  {} {}: {:.1f} ms per step{}\n", e.gpus, e.gpus == 1 ? "GPU" : "GPUs",
         1e3 * e.seconds, e.transport.empty() ? "" : ", transport " + e.transport);
  for (const std::string& line : choice.figures) show(stdout, "  {}\n", line);
}

}  // namespace weft::app
