#include <algorithm>
#include <cstddef>
#include <limits>
#include <utility>

#include "host/io/scene/scene_parts.hpp"
#include "host/io/scene/scene_selection.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

void read_circle(Fields& fields, Handle& handle) {
  Fields circle =
      fields.object("circle", {"circumference", "direction", "center", "axis0", "axis1"});
  handle.shape = Handle::Shape::circle;
  handle.circumference = circle.number("circumference", quantity::length);
  handle.direction = circle.vector<2>("direction", handle.direction);
  handle.center = circle.vector<3>("center", handle.center);
  handle.axis0 = circle.vector<3>("axis0", handle.axis0);
  handle.axis1 = circle.vector<3>("axis1", handle.axis1);
}

/// Number of the obstacle that a pin follows, -1 without the key.
Index read_pinning_obstacle(Fields& fields, const Scene& scene) {
  if (!fields.has("obstacle")) return -1;
  if (fields.has("motion")) fields.refuse("obstacle", "an obstacle or a motion, not both");
  std::vector<std::string> names;
  for (const Obstacle& obstacle : scene.obstacles) names.push_back(obstacle.name);
  return static_cast<Index>(fields.choice("obstacle", names, {}));
}

}  // namespace

void read_pins(Fields& root, const std::vector<ClothGroup>& groups, Scene& scene) {
  for (Fields& fields : root.objects("pins", {"cloth", "vertices", "corners", "edge", "box",
                                              "group", "motion", "obstacle", "release_time"})) {
    const NamedCloths cloths = read_named_cloths(fields, groups, scene);
    const std::vector<std::vector<Index>> selection =
        read_selection(fields, fields.one_of(selection_keys()), cloths, scene);
    const Index obstacle = read_pinning_obstacle(fields, scene);
    const Motion motion = obstacle < 0 ? read_motion(fields, "motion") : Motion{};
    const double release_time =
        fields.number_or_null("release_time").value_or(std::numeric_limits<double>::infinity());
    if (!(release_time > 0)) fields.refuse("release_time", "a time > 0, or null for never");
    for (Index k = 0; k < cloths.count; ++k) {
      const std::vector<Index>& vertices = selection[static_cast<std::size_t>(k)];
      if (!vertices.empty())
        scene.pins.push_back({cloths.first + k, vertices, motion, obstacle, release_time});
    }
  }
}

void read_handles(Fields& root, const std::vector<ClothGroup>& groups, Scene& scene) {
  std::vector<std::string> selections = selection_keys();
  selections.emplace_back("glue");
  std::vector<std::string> keys = selections;
  keys.insert(keys.end(), {"cloth", "circle", "motion", "along", "stiffness", "start_time",
                           "end_time", "fade_time"});
  for (Fields& fields : root.objects("handles", keys)) {
    const NamedCloths cloths = read_named_cloths(fields, groups, scene);
    const std::string key = fields.one_of(selections);
    Handle handle;
    std::vector<std::vector<Index>> selection;
    if (key == "glue") {
      handle.shape = Handle::Shape::glue;
      const auto& mesh = scene.cloths[static_cast<std::size_t>(cloths.first)].mesh;
      const auto pair =
          fields.integers("glue", 0, static_cast<std::int64_t>(mesh.positions.size()) - 1, 2);
      selection.assign(static_cast<std::size_t>(cloths.count),
                       {static_cast<Index>(pair[0]), static_cast<Index>(pair[1])});
      if (fields.has("circle")) fields.refuse("circle", "no circle beside glue");
    } else {
      selection = read_selection(fields, key, cloths, scene);
    }
    if (fields.has("circle")) read_circle(fields, handle);
    handle.motion = read_motion(fields, "motion");
    if (fields.has("along")) {
      if (key == "glue") fields.refuse("along", "no direction beside glue");
      handle.along = fields.direction("along", handle.along);
    }
    handle.stiffness = fields.number("stiffness", quantity::spring, handle.stiffness);
    handle.start_time = fields.number("start_time", handle.start_time);
    handle.end_time = fields.number_or_null("end_time").value_or(handle.end_time);
    handle.fade_time = fields.number("fade_time", handle.fade_time);
    for (Index k = 0; k < cloths.count; ++k) {
      handle.cloth = cloths.first + k;
      handle.vertices = std::move(selection[static_cast<std::size_t>(k)]);
      if (!handle.vertices.empty()) scene.handles.push_back(handle);
    }
  }
}

void read_wind(Fields& root, Scene& scene) {
  Fields fields = root.object("wind", {"density", "velocity", "drag"});
  scene.wind.density = fields.number("density", scene.wind.density);
  scene.wind.velocity = fields.vector<3>("velocity", scene.wind.velocity);
  scene.wind.drag = fields.number("drag", scene.wind.drag);
  if (scene.wind.density == 0 && (length(scene.wind.velocity) > 0 || scene.wind.drag > 0))
    scene.warnings.push_back("wind: velocity " + fields.shown("velocity") + " m/s and drag " +
                             fields.shown("drag") +
                             " have no effect, as density is 0; that of air is 1.2 kg/m^3");
}

}  // namespace weft::io
