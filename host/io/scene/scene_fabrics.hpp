#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace weft::io {

/// Gives cloths and garments that name a fabric, or neither fabric nor material, a material: adds
/// it to "materials", unless one of that name is the same fabric already, and names it in the
/// cloth. Everything behind reads materials only, and the resolved scene says which numbers were
/// used.
/// @param warnings gets a line for each cloth that names nothing although there are materials
/// @throws SceneError for a name that no fabric has, or a fabric beside a material
void name_materials_of_fabrics(nlohmann::json& document, const std::string& file,
                               std::vector<std::string>& warnings);

}  // namespace weft::io
