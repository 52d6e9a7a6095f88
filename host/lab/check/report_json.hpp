#pragma once

#include <nlohmann/json.hpp>

#include "host/lab/check/validator.hpp"

namespace weft::lab {

/// A verdict as a JSON object:
///   clean, triangle_count, obstacle_triangle_count,
///   cloth_cloth {count, pairs [[a, b], ...]}, cloth_obstacle {the same},
///   inverted, degenerate, nonfinite_vertices, nonfinite_obstacle_vertices {count, list},
///   strain {triangle_count, largest, smallest {min, p1, p50, p99, max}}, or null if none was
///   measured.
/// Lists are cut off at ValidatorOptions::list_limit, counts never.
nlohmann::ordered_json to_json(const FrameVerdict& verdict);

}  // namespace weft::lab
