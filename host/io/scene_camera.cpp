#include <numbers>

#include "host/io/scene_parts.hpp"

namespace weft::io {

void read_camera(Fields& root, Scene& scene) {
  constexpr double degree = std::numbers::pi / 180;
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
    return;
  }
  const auto size = fields.integers("resolution", 1, 16384, 2);
  camera.width = static_cast<int>(size[0]);
  camera.height = static_cast<int>(size[1]);
}

}  // namespace weft::io
