#include "host/io/pattern/garment_scene.hpp"

#include <utility>

#include "host/base/atomic_file.hpp"
#include "host/base/file_bytes.hpp"
#include "host/base/file_extension.hpp"

namespace weft::io {

using json = nlohmann::json;

json garment_scene(const GarmentSceneRequest& request) {
  json garments = json::array();
  for (const GarmentEntry& entry : request.garments) {
    json garment{{"name", entry.name},
                 {"pattern", entry.pattern_file},
                 {"edge", request.edge},
                 {"material", "cloth"}};
    if (request.garments.size() > 1) garment["layer"] = garments.size();
    for (const HeldLabel& held : entry.held) {
      json attachment{{"label", held.label}};
      if (held.height) attachment["at"] = *held.height;
      garment["attach"].push_back(std::move(attachment));
    }
    garments.push_back(std::move(garment));
  }
  // Steps of this length make cloth tremble for ever where less stiffness damps it.
  json scene{
      {"name", request.name},
      {"description", request.description},
      {"time", {{"step", 0.01}, {"frame_rate", 25}, {"frames", 250}, {"until", "rest"}}},
      {"materials",
       {{"cloth", {{"fabric", request.fabric}, {"damping", {{"mass", 4}, {"stiffness", 0.002}}}}}}},
      {"garments", std::move(garments)}};
  if (!request.body_file.empty())
    scene["obstacles"] = {{{"name", "body"}, {"mesh", request.body_file}, {"up", "y"}}};
  return scene;
}

std::vector<HeldLabel> labels_to_hold(const Garment& garment) {
  std::vector<HeldLabel> held;
  for (const GarmentLabel& label : garment.labels)
    if (label.label == waist_label || label.label == strapless_label)
      held.push_back({label.label, {}});
  return held;
}

void copy_pattern(const json& document, const std::filesystem::path& file,
                  const std::filesystem::path& copy) {
  json copied = document;
  json& pattern = copied.at("pattern");
  if (const auto outlines = pattern.find("outlines"); outlines != pattern.end()) {
    const std::filesystem::path drawing = file.parent_path() / outlines->get<std::string>();
    const std::filesystem::path beside =
        copy.stem().string() + "_outlines" + lower_extension(drawing);
    write_file_atomically(copy.parent_path() / beside, read_file_bytes(drawing));
    *outlines = beside.string();
  }
  write_file_atomically(copy, copied.dump(1) + "\n");
}

}  // namespace weft::io
