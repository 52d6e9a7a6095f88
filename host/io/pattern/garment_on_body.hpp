#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "host/io/pattern/garment.hpp"

/// Whether the panels of a garment fit the body that they are put around.
namespace weft::io {

/// Share of a garment's height at which there is body within or beside it, up to
/// most_panel_distance away: 1 for clothes around somebody who stands, little if the body lies, has
/// another axis up or another size.
/// @param body [m] y up, not empty
double height_around_body(const Garment& garment, const Mesh& body);

/// @param body     [m] y up, not empty
/// @param document the pattern, which says its units
/// @param file     of the pattern, for messages
/// @throws SceneError naming the units if all panels together are smaller or larger than any
///         garment for this body
void refuse_other_size(const Garment& garment, const Mesh& body, const nlohmann::json& document,
                       const std::string& file);

}  // namespace weft::io
