#include "host/io/scene/scene_fabrics.hpp"

#include <algorithm>
#include <cstddef>
#include <optional>

#include "host/input/nearest_word.hpp"
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

/// Names of fabrics as `choice` knows them.
std::vector<std::string> fabric_names() {
  std::vector<std::string> names;
  for (const Fabric& fabric : fabrics()) names.emplace_back(fabric.name);
  return names;
}

/// @throws SceneError if "fabric" names a material of the scene, and no fabric has this name
void refuse_material_as_fabric(const Fields& fields, const std::string& key, const json& value,
                               const json& materials, const std::vector<std::string>& fabrics) {
  if (!value.is_string()) return;
  const auto& name = value.get_ref<const std::string&>();
  if (!materials.contains(name) || std::find(fabrics.begin(), fabrics.end(), name) != fabrics.end())
    return;
  const std::string shown = short_text(value);
  fields.refuse(key, shown,
                "a fabric; " + shown + " is a material of the scene: \"material\": " + shown);
}

/// @throws SceneError if "material" names no material of the scene, but a fabric, or nearly so
void refuse_fabric_as_material(const Fields& fields, const std::string& key, const json& value,
                               const json& materials) {
  if (!value.is_string()) return;
  const auto& name = value.get_ref<const std::string&>();
  const std::optional<std::string> fabric = nearest_word(name, fabric_names());
  if (materials.contains(name) || !fabric) return;
  std::vector<std::string> defined;
  std::string list;
  for (const auto& [material, unused] : materials.items()) {
    defined.push_back(material);
    list += (list.empty() ? ": " : ", ") + short_text(json(material));
  }
  const bool is_fabric = *fabric == name;
  if (!is_fabric && nearest_word(name, defined)) return;
  const std::string written = "\"fabric\": \"" + *fabric + "\"";
  fields.refuse(key, short_text(value),
                "a material that the scene defines" +
                    (list.empty() ? ", and it defines none" : list) +
                    (is_fabric ? "; \"" + name + "\" is a fabric: " + written
                               : "; did you mean " + written + "?"));
}

/// Replaces "fabric", a name or names by panel, by "material" in the same form.
/// @param by_panel whether names by panel may be there
/// @throws SceneError for a name that no fabric has, or beside a material
void name_material(json& owner, bool by_panel, const std::string& file, const std::string& path,
                   json& materials) {
  json scratch;
  const json given = owner;
  Fields fields(given, scratch, file, path, {});
  if (given.contains("fabric") && given.contains("material"))
    fields.refuse("fabric", "fabric or material, not both" +
                                std::string(by_panel ? "; both take names by panel" : ""));
  const std::vector<std::string> names = fabric_names();
  if (by_panel && fields.is_object("fabric")) {
    Fields panels = fields.object("fabric", {});
    json material = json::object();
    for (const std::string& panel : panels.present_keys()) {
      refuse_material_as_fabric(panels, panel, given.at("fabric").at(panel), materials, names);
      material[panel] = material_of(names[panels.choice(panel, names, {})], materials);
    }
    // The reader of garments knows the panels, and reports others under the key that was given.
    owner["material"] = std::move(material);
  } else {
    if (given.contains("fabric"))
      refuse_material_as_fabric(fields, "fabric", given.at("fabric"), materials, names);
    owner["material"] = material_of(
        given.contains("fabric") ? names[fields.choice("fabric", names, {})] : default_fabric,
        materials);
    owner.erase("fabric");
  }
}

}  // namespace

void name_materials_of_fabrics(json& document, const std::string& file,
                               std::vector<std::string>& warnings) {
  // Any other type is for the readers of these keys to refuse.
  if (!document.is_object()) return;
  if (document.contains("materials") && !document.at("materials").is_object()) return;
  const bool has_materials = document.contains("materials") && !document.at("materials").empty();
  for (const char* list : {"cloths", "garments"}) {
    if (!document.contains(list) || !document.at(list).is_array()) continue;
    json& cloths = document.at(list);
    for (std::size_t i = 0; i < cloths.size(); ++i) {
      json& cloth = cloths[i];
      if (!cloth.is_object() || (cloth.contains("material") && !cloth.contains("fabric"))) continue;
      const std::string path = list + ("[" + std::to_string(i) + "]");
      if (has_materials && !cloth.contains("fabric"))
        warnings.push_back(path +
                           ": it names none of the scene's materials and no fabric, so it "
                           "is " +
                           std::string(default_fabric));
      name_material(cloth, list == std::string("garments"), file, path, document["materials"]);
    }
  }
  // Only now are all materials there, also those that fabrics have become.
  const json defined = document.value("materials", json::object());
  for (const char* list : {"cloths", "garments"}) {
    if (!document.contains(list) || !document.at(list).is_array()) continue;
    const json& cloths = document.at(list);
    for (std::size_t i = 0; i < cloths.size(); ++i) {
      if (!cloths[i].is_object() || !cloths[i].contains("material")) continue;
      json scratch;
      Fields fields(cloths[i], scratch, file, list + ("[" + std::to_string(i) + "]"), {});
      const json& material = cloths[i].at("material");
      refuse_fabric_as_material(fields, "material", material, defined);
      if (!material.is_object()) continue;
      Fields panels = fields.object("material", {});
      for (const std::string& panel : panels.present_keys())
        refuse_fabric_as_material(panels, panel, material.at(panel), defined);
    }
  }
}

}  // namespace weft::io
