#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host/io/pattern/garment.hpp"

namespace weft::io {

/// Edges that stay at a height.
struct HeldLabel {
  std::string label;
  std::optional<double> height{};  ///< [m] empty: where they start
};

/// A garment of a scene, as the scene names it.
struct GarmentEntry {
  std::string name;  ///< of the cloth: letters, digits, _ and -
  std::string pattern_file;
  std::vector<HeldLabel> held;
};

/// What a scene of garments on one body needs to know.
struct GarmentSceneRequest {
  std::string name;  ///< of the scene: letters, digits, _ and -
  std::string description;
  std::string fabric;
  double edge = default_garment_edge;  ///< [m]
  std::vector<GarmentEntry> garments;  ///< from the inside out
  std::string body_file;               ///< empty: none
};

/// A scene in which garments are sewn around a body and fall until they hang. As
/// scenes/scene.schema.json describes it.
nlohmann::json garment_scene(const GarmentSceneRequest& request);

/// Label of the edges at a waist, which GarmentCode's simulator holds, and of those at the top of a
/// strapless dress.
inline constexpr const char* waist_label = "lower_interface";
inline constexpr const char* strapless_label = "strapless_top";

/// Which edges of a garment to hold.
std::vector<HeldLabel> labels_to_hold(const Garment& garment);

/// Writes a copy of a pattern, and of the drawing that it takes outlines from, beside each other.
/// @param document that `file` holds
/// @param copy     path of the pattern's copy
/// @throws SceneError if a file cannot be read or written
void copy_pattern(const nlohmann::json& document, const std::filesystem::path& file,
                  const std::filesystem::path& copy);

}  // namespace weft::io
