#include <algorithm>
#include <iterator>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host/io/json/overrides.hpp"
#include "host/io/scene/scene_file.hpp"
#include "host/io/scene/scene_parts.hpp"
#include "weft/error.hpp"

/// Values for tests and comparisons, which no user has a reason to set. They are no part of the
/// schema: a run writes those that were set into its scene.json, as an object of values by path, so
/// that whoever reads it again simulates the same.
namespace weft::io {

void apply_experimental(nlohmann::json& scene, const std::string& text, const std::string& file) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0)
    throw SceneError(file, "--experimental", short_text(nlohmann::json(text)),
                     "path=value, such as contact.stiffness=30");
  if (!scene.is_object()) return;  // refused when it is read, as are other values than an object
  nlohmann::json& values = scene[experimental_key];
  if (values.is_null()) values = nlohmann::json::object();
  const std::string path = text.substr(0, equals);
  if (values.is_object()) values[path] = override_value(text.substr(equals + 1), file, path);
}

namespace {

constexpr const char* stiffness_path = "contact.stiffness";

/// Read where the other keys of their object are, once read_experimental() has put them there.
constexpr const char* hidden_paths[] = {
    "bending",
    "contact.self_certificate",
    "contact.substep_bisections",
    "contact.zone_rounds",
    "jitter.seed",
    "method.asynchronous.layers",
    "method.asynchronous.narrow",
    "method.asynchronous.optimistic",
    "method.asynchronous.restitution",
    "method.asynchronous.rollbacks",
    "method.asynchronous.smallest_step",
    "method.asynchronous.stiffness",
    "method.asynchronous.window",
    "method.implicit.sleep_window",
    "method.time_parallel.blend_frames",
    "method.time_parallel.boundary_tolerance",
    "method.time_parallel.coarse_integrator",
    "method.time_parallel.coarse_mesh",
    "method.time_parallel.coarse_newton_iterations",
    "method.time_parallel.coarse_newton_tolerance",
    "method.time_parallel.coarse_step",
    "method.time_parallel.coarse_thickness",
    "method.time_parallel.coarse_tolerance",
    "method.time_parallel.coarsening",
    "method.time_parallel.partition",
    "method.time_parallel.ratio",
    "method.time_parallel.recovery.factor",
    "method.time_parallel.recovery.iterations",
    "method.time_parallel.recovery.tolerance",
    "method.view.anticipation",
    "method.view.compensation",
    "method.view.compensation_power",
    "method.view.factor_back",
    "method.view.margin",
    "method.view.pixel_min",
    "method.view.predict_obstacles",
    "method.view.transfer_threshold",
    "remeshing.aspect_min",
    "remeshing.energy_share",
    "remeshing.flip_threshold",
    "solver.line_search",
    "solver.max_iterations",
    "solver.newton_tolerance",
    "solver.partial_rows",
    "solver.preconditioner",
    "solver.rebalance",
    "solver.transport",
};

nlohmann::json::json_pointer pointer_of(std::string path) {
  std::replace(path.begin(), path.end(), '.', '/');
  return nlohmann::json::json_pointer('/' + path);
}

std::vector<std::string> all_paths() {
  std::vector<std::string> all{stiffness_path};
  all.insert(all.end(), std::begin(hidden_paths), std::end(hidden_paths));
  return all;
}

/// Sets a value in an object, unless something that is no object is on its way: that is refused
/// when the object is read.
void put(nlohmann::json& document, const nlohmann::json::json_pointer& place,
         const nlohmann::json& value) {
  for (auto at = place.parent_pointer(); !at.empty(); at = at.parent_pointer())
    if (document.contains(at) && !document.at(at).is_object()) return;
  document[place] = value;
}

}  // namespace

bool is_experimental(std::string_view path) {
  return path == stiffness_path || std::find(std::begin(hidden_paths), std::end(hidden_paths),
                                             path) != std::end(hidden_paths);
}

Settings split_settings(const std::vector<std::string>& settings) {
  Settings split;
  for (const std::string& text : settings)
    (is_experimental(text.substr(0, text.find('='))) ? split.experimental : split.keys)
        .push_back(text);
  return split;
}

nlohmann::json read_experimental(nlohmann::json& document, Scene& scene) {
  nlohmann::json resolved;
  if (!document.is_object()) return resolved;
  for (const char* path : hidden_paths) {
    const auto place = pointer_of(path);
    if (document.contains(place))
      throw SceneError(scene.file, path, short_text(document.at(place)),
                       std::string("--experimental ") + path + "=VALUE");
  }
  if (!document.contains(experimental_key)) return resolved;
  const nlohmann::json values = std::move(document[experimental_key]);
  document.erase(experimental_key);
  Fields fields(values, resolved, scene.file, experimental_key, all_paths());
  if (values.contains(stiffness_path))
    scene.contact.stiffness = fields.number(stiffness_path, quantity::repulsion);
  for (const char* path : hidden_paths) {
    if (!values.contains(path)) continue;
    fields.record(path, values.at(path));
    put(document, pointer_of(path), values.at(path));
  }
  return resolved;
}

void hide_experimental(nlohmann::json& resolved) {
  for (const char* path : hidden_paths) {
    const auto place = pointer_of(path);
    const auto parent = place.parent_pointer();
    if (!resolved.contains(place)) continue;
    resolved.at(parent).erase(place.back());
    if (resolved.at(parent).empty()) resolved.at(parent.parent_pointer()).erase(parent.back());
  }
}

}  // namespace weft::io
