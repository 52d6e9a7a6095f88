#pragma once

#include <array>
#include <string>
#include <vector>

#include "host/io/pattern/sewing_pattern.hpp"
#include "weft/scene.hpp"

namespace weft::io {

/// A panel within the mesh of its garment. Vertices and triangles of a panel follow each other.
struct GarmentPanel {
  std::string name;   ///< one word, different for each
  std::string label;  ///< part of the body, such as "body", "arm" or "leg"; empty: not known
  Index first_vertex = 0;
  Index vertex_count = 0;
  Index first_triangle = 0;
  Index triangle_count = 0;
  std::vector<std::vector<Index>> edges{};  ///< vertices along each edge of the pattern's panel
};

/// Vertices that a stitch makes one, pair by pair along it.
struct GarmentSeam {
  Index stitch = 0;  ///< into SewingPattern::stitches
  std::vector<std::array<Index, 2>> pairs;
};

/// Vertices of the edges that a pattern labels.
struct GarmentLabel {
  std::string label;
  std::vector<Index> vertices;  ///< ascending
};

/// The panels of a pattern as one mesh of several components, not sewn yet.
struct Garment {
  /// [m] y up, where the pattern puts the panels. Material coordinates are those of each panel for
  /// itself, with warp along the steeper one of its two axes. Groups are the panels, in their
  /// order. Parts are the labels, or the names of panels without one; there are none if no panel
  /// has a label.
  Mesh mesh;
  std::vector<GarmentPanel> panels;
  std::vector<GarmentSeam> seams;  ///< no pair twice, none of a vertex with itself
  std::vector<GarmentLabel> labels;
  std::vector<std::string> notes;  ///< decisions that differ from the file, a line each
};

/// Where the length of edges was given, for messages.
struct EdgeField {
  std::string file;  ///< empty: the command line
  std::string field = "edge";
};

/// Cuts a pattern into triangles. Both sides of a stitch get as many vertices; triangles of
/// different panels that sewing would lay on each other are split.
/// @param edge  [m] length of edges that is aimed at
/// @param given where that was given
/// @throws SceneError naming panel, edge or stitch: an outline that crosses itself or has no area,
/// a
///         stitch whose sides differ too much, fronts that cannot meet, more triangles than
///         most_garment_triangles
Garment make_garment(const SewingPattern& pattern, double edge, const EdgeField& given = {});

inline constexpr double most_garment_triangles = 5e6;
inline constexpr double default_garment_edge = 0.02;  ///< [m]

}  // namespace weft::io
