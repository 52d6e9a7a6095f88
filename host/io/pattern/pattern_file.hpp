#pragma once

#include <nlohmann/json.hpp>

#include "host/io/pattern/sewing_pattern.hpp"

/// Sewing patterns in the JSON format of GarmentCode (Korosteleva and Sorkine-Hornung 2023). Beside
/// its keys there may be "outlines", a file with the outlines of panels that have no "vertices"
/// here (outline_file.hpp) and then "edge_labels", and the "grain" of a panel.
namespace weft::io {

/// Whether a document is a specification of GarmentCode: it has "pattern" with "panels".
bool is_sewing_pattern(const nlohmann::json& document);

/// Whether a document seems to be meant as one.
bool resembles_sewing_pattern(const nlohmann::json& document);

/// @throws SceneError that says what is wrong, unless is_sewing_pattern()
void require_sewing_pattern(const nlohmann::json& document, const std::string& file);

/// Reads a specification. Keys that are not known are passed over, since such files come from
/// others. The name of the pattern is that of the file without "_specification".
/// @param document is_sewing_pattern()
/// @param file     for messages; outlines lie below its folder
/// @throws SceneError naming panel, edge or stitch: an outline that is not closed, an edge without
///         length, an arc that does not reach, a stitch to nothing, a value of another type, not
///         finite or beyond what clothes need
SewingPattern read_sewing_pattern(const nlohmann::json& document, const std::string& file);

}  // namespace weft::io
