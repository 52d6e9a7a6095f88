#include "host/io/pattern/garment_scene.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/io/mesh/mesh_file.hpp"

namespace weft::io {

using json = nlohmann::json;

json garment_scene(const Garment& garment, const GarmentSceneRequest& request) {
  json seams = json::array();
  for (const GarmentSeam& seam : garment.seams)
    if (!seam.pairs.empty())
      seams.push_back({{"cloths", {request.name, request.name}}, {"pairs", seam.pairs}});
  json scene{
      {"name", request.name},
      {"description", request.description},
      {"up", "y"},
      {"time", {{"step", 0.005}, {"frame_rate", 25}, {"frames", 250}, {"until", "rest"}}},
      {"materials", {{"cloth", {{"fabric", request.fabric}, {"damping", {{"mass", 4}}}}}}},
      {"cloths", {{{"name", request.name}, {"mesh", request.garment_file}, {"material", "cloth"}}}},
      {"contact", {{"untangle", true}}}};
  if (!request.body_file.empty())
    scene["obstacles"] = {{{"name", "body"}, {"mesh", request.body_file}}};
  if (!seams.empty()) scene["seams"] = std::move(seams);
  return scene;
}

void write_garment(const std::filesystem::path& path, const std::string& name,
                   const Garment& garment) {
  write_obj(path, {{name, garment.mesh}}, Normals::none, Groups::faces);
}

}  // namespace weft::io
