#pragma once

#include <nlohmann/json.hpp>

#include "host/lab/worn/worn.hpp"

namespace weft::lab {

/// A verdict as a JSON object: garment, worn, faults [text], shoulders_covered,
///   openings [{panels, around, around_at_start, length_m, slide_m, twist_degrees}],
///   panels [{name, part, drift_m, twist_degrees, outward, outward_at_start, stretch_max,
///   stretched_share}].
/// What is not known is null.
nlohmann::ordered_json to_json(const GarmentVerdict& verdict);

}  // namespace weft::lab
