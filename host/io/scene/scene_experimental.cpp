#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "host/io/json/experimental_paths.hpp"
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

nlohmann::json::json_pointer pointer_of(std::string path) {
  std::replace(path.begin(), path.end(), '.', '/');
  return nlohmann::json::json_pointer('/' + path);
}

std::vector<std::string> all_paths() {
  std::vector<std::string> all{stiffness_path};
  all.insert(all.end(), experimental_paths().begin(), experimental_paths().end());
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
  for (const char* path : experimental_paths()) {
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
  for (const char* path : experimental_paths()) {
    if (!values.contains(path)) continue;
    fields.record(path, values.at(path));
    put(document, pointer_of(path), values.at(path));
  }
  return resolved;
}

void hide_experimental(nlohmann::json& resolved) {
  for (const char* path : experimental_paths()) {
    const auto place = pointer_of(path);
    const auto parent = place.parent_pointer();
    if (!resolved.contains(place)) continue;
    resolved.at(parent).erase(place.back());
    if (resolved.at(parent).empty()) resolved.at(parent.parent_pointer()).erase(parent.back());
  }
}

}  // namespace weft::io
