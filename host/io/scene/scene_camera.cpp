#include <numbers>

#include "host/io/scene/scene_parts.hpp"

namespace weft::io {
namespace {

constexpr double degree = std::numbers::pi / 180;

nlohmann::json json_of(const Vec3<double>& v) {
  return {v[0], v[1], v[2]};
}

nlohmann::json json_of(const CameraKey& key) {
  return {{"time", key.time},      {"position", json_of(key.position)},
          {"jump", key.jump},      {"look_at", json_of(key.look_at)},
          {"up", json_of(key.up)}, {"field_of_view", key.field_of_view / degree}};
}

}  // namespace

void read_camera(Fields& root, Scene& scene) {
  Camera& camera = scene.camera;
  Fields fields = root.object("camera", {"keys", "resolution"});
  for (Fields& entry :
       fields.objects("keys", {"time", "position", "look_at", "up", "field_of_view", "jump"})) {
    CameraKey key;
    key.time = entry.number("time", 0.0);
    key.position = entry.vector<3>("position");
    key.look_at = entry.vector<3>("look_at");
    key.up = entry.vector<3>("up", Vec3<double>{0, 0, 1});
    key.field_of_view = entry.number("field_of_view", 40.0) * degree;
    key.jump = entry.boolean("jump", false);
    camera.keys.push_back(key);
  }
  if (!fields.has("resolution")) {
    fields.record("resolution", {camera.width, camera.height});
  } else {
    const auto size = fields.integers("resolution", 1, 16384, 2);
    camera.width = static_cast<int>(size[0]);
    camera.height = static_cast<int>(size[1]);
  }
  if (scene.method != "view" || !camera.keys.empty()) return;
  camera.keys.push_back(framing_camera(scene));
  fields.record("keys", {json_of(camera.keys[0])});
}

void read_view(Fields& method, ViewSettings& v) {
  Fields fields =
      method.object("view", {"factor_back", "factor_out", "margin", "anticipation",
                             "transfer_threshold", "pixel_min", "two_sided", "occlusion",
                             "predict_obstacles", "compensation", "compensation_power"});
  v.factor_back = fields.number("factor_back", v.factor_back);
  v.factor_out = fields.number("factor_out", v.factor_out);
  v.margin = fields.number("margin", v.margin);
  v.anticipation = fields.number("anticipation", v.anticipation);
  v.transfer_threshold = fields.number("transfer_threshold", v.transfer_threshold);
  v.pixel_min = fields.number("pixel_min", v.pixel_min);
  v.two_sided = fields.boolean("two_sided", v.two_sided);
  v.occlusion = fields.boolean("occlusion", v.occlusion);
  v.predict_obstacles = fields.boolean("predict_obstacles", v.predict_obstacles);
  constexpr BucklingCompensation kinds[] = {BucklingCompensation::none, BucklingCompensation::full,
                                            BucklingCompensation::area};
  v.compensation = kinds[fields.choice("compensation", {"none", "full", "area"}, 2)];
  v.compensation_power = fields.number("compensation_power", v.compensation_power);
}

}  // namespace weft::io
