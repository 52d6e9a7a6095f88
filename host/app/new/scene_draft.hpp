#pragma once

#include <optional>
#include <string>

#include "host/app/new/mesh_guess.hpp"
#include "weft/scene.hpp"

namespace weft::app {

/// Whether a draft explains itself.
enum class Comments { none, lines };

/// Findings of `weft new` about a scene, in the order of the file. An empty text or nothing
/// is left out.
struct SceneDraft {
  std::string name;
  std::string command;  ///< that wrote it
  Guess units, up;
  int frames = 50;
  std::string frames_reason;
  std::string cloth_file;   ///< as the scene names it
  std::string cloth_facts;  ///< number and lengths of its edges
  bool textured = false;    ///< the cloth's file has texture coordinates
  std::string repaired;     ///< what repair does to the cloth; empty: it needs none
  std::string fabric;
  std::string fabric_facts;
  std::string body_file;
  bool repair_body = false;
  std::optional<double> floor;           ///< [m] height, for cloth that lies above nothing
  std::optional<Vec3<double>> pin_low;   ///< [m] box that holds cloth up which has no body
  std::optional<Vec3<double>> pin_high;  ///< [m]
  double cloth_size = 1;                 ///< [m]
  Vec3<double> cloth_centre{0, 0, 0};    ///< [m]
  std::optional<double> thickness;       ///< [m] of contact
  std::string thickness_reason;
  std::optional<CameraKey> camera;
};

/// The scene as JSON, with a line of comment above what needs one.
std::string draft_text(const SceneDraft& draft, Comments comments);

}  // namespace weft::app
