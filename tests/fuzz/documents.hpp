#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>

/// Scenes as inputs: a scene names other files, and may ask for more than a short run can take.
namespace weft::fuzz {

/// Parses a scene and makes it safe and small: nothing for a text that is refused, or that names
/// files outside of the folder; few cells, copies, cloths and obstacles for many.
std::optional<nlohmann::json> small_document(std::string_view input);

/// Puts files for scenes to name into folder(): square.obj, cotton.json, tube.json, walk.mot,
/// walk.bvh, body_0.obj, body_1.obj.
void put_parts();

}  // namespace weft::fuzz
