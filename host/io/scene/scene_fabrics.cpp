#include "host/io/scene/scene_fabrics.hpp"

#include <cstddef>

#include "host/io/json/json_fields.hpp"
#include "host/scene/fabric/fabrics.hpp"

namespace weft::io {
namespace {

using nlohmann::json;

/// Name of the material that is this fabric and nothing else; made if there is none.
std::string material_of(const std::string& fabric, json& materials) {
  const json wanted{{"fabric", fabric}};
  std::string name = fabric;
  while (materials.contains(name) && materials.at(name) != wanted) name += "_fabric";
  materials[name] = wanted;
  return name;
}

/// @throws SceneError for a name that no fabric has, or beside a material
std::string fabric_of(const json& cloth, const std::string& file, const std::string& path) {
  if (!cloth.contains("fabric")) return default_fabric;
  json scratch;
  Fields fields(cloth, scratch, file, path, {});
  if (cloth.contains("material"))
    fields.refuse("fabric", "a value that stands alone, without material");
  std::vector<std::string> names;
  for (const Fabric& fabric : fabrics()) names.emplace_back(fabric.name);
  return names[fields.choice("fabric", names, {})];
}

}  // namespace

void name_materials_of_fabrics(json& document, const std::string& file,
                               std::vector<std::string>& warnings) {
  // Any other type is for the readers of these keys to refuse.
  if (!document.is_object() || !document.contains("cloths") || !document.at("cloths").is_array())
    return;
  if (document.contains("materials") && !document.at("materials").is_object()) return;
  const bool has_materials = document.contains("materials") && !document.at("materials").empty();
  json& cloths = document.at("cloths");
  for (std::size_t i = 0; i < cloths.size(); ++i) {
    json& cloth = cloths[i];
    if (!cloth.is_object() || (cloth.contains("material") && !cloth.contains("fabric"))) continue;
    const std::string path = "cloths[" + std::to_string(i) + "]";
    const std::string fabric = fabric_of(cloth, file, path);
    if (has_materials && !cloth.contains("fabric"))
      warnings.push_back(
          path + ": it names none of the scene's materials and no fabric, so it is " + fabric);
    cloth["material"] = material_of(fabric, document["materials"]);
    cloth.erase("fabric");
  }
}

}  // namespace weft::io
