#pragma once

#include "host/io/json_fields.hpp"
#include "host/scene/ribbon.hpp"

namespace weft::io {

/// "ribbon" of a cloth, but for its cells.
/// @throws SceneError
Ribbon read_ribbon(Fields& fields);

}  // namespace weft::io
