#pragma once

#include <nlohmann/json.hpp>

#include "host/io/json/json_fields.hpp"

namespace weft::io {

/// A cloth's block "remeshing" of ARCSim as one of weft. What it leaves out does not refine.
/// @return null if it has no size, without which ARCSim never stops to refine
/// @throws SceneError with key, value and what is allowed
nlohmann::json read_arcsim_remeshing(Fields& cloth);

}  // namespace weft::io
