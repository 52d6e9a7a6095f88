#include <utility>

#include "host/io/json/overrides.hpp"
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

nlohmann::json read_experimental(nlohmann::json& document, Scene& scene) {
  nlohmann::json resolved;
  if (!document.is_object() || !document.contains(experimental_key)) return resolved;
  const nlohmann::json values = std::move(document[experimental_key]);
  document.erase(experimental_key);
  Fields fields(values, resolved, scene.file, experimental_key, {"contact.stiffness"});
  scene.contact.stiffness =
      fields.number("contact.stiffness", quantity::repulsion, scene.contact.stiffness);
  return resolved;
}

}  // namespace weft::io
