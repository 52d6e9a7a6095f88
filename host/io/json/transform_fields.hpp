#pragma once

#include <string>
#include <vector>

#include "host/io/json/json_fields.hpp"
#include "weft/scene.hpp"

/// Readers of an object's placement. All throw SceneError.
namespace weft::io {

/// Keys of a placement.
std::vector<std::string> transform_keys();
/// translate, rotate [degrees, x, y, z], scale of an object
Transform read_transform(Fields& fields);
/// [degrees, x, y, z] with an axis that is not zero
void read_rotation(Fields& fields, Transform& transform);

}  // namespace weft::io
