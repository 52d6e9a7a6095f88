#pragma once

#include "host/geometry/ribbon.hpp"
#include "host/io/json/json_fields.hpp"

namespace weft::io {

/// "ribbon" of a cloth, but for its cells.
/// @throws SceneError
Ribbon read_ribbon(Fields& fields);

}  // namespace weft::io
