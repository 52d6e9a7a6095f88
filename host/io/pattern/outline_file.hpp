#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host/io/pattern/sewing_pattern.hpp"

namespace weft::io {

/// Outlines of panels in a file of another program, which knows nothing of stitches and of where
/// panels stand: SVG or DXF.
class OutlineFile {
 public:
  virtual ~OutlineFile() = default;

  /// Names of the panels, in the order of the file, each once. Read from any program's file: those
  /// of shapes that are no closed outline are left out.
  virtual std::vector<std::string> names() const = 0;

  /// A panel by its name, in metres with y up. Edges are those of the file, in its order, and run
  /// as they do there.
  /// @param field for messages: who asks for it
  /// @throws SceneError if there is none, or it is no single closed outline
  virtual PatternPanel panel(const std::string& name, const std::string& field) const = 0;
};

inline constexpr double largest_outline_coordinate = 100;  ///< [m]
inline constexpr double least_outline_edge = 1e-5;         ///< [m]
inline constexpr std::size_t most_outline_panels = 10'000;
inline constexpr std::size_t most_outline_corners = 10'000;  ///< of a panel
inline constexpr std::size_t most_outline_points = 100'000;  ///< of a panel

/// Whether the ending of a file is one that open_outlines() reads: .dxf or .svg.
bool holds_outlines(const std::filesystem::path& file);

/// @param unit [m] length of the file's unit; nothing: as the file says
/// @throws SceneError naming file and line or element
std::unique_ptr<OutlineFile> open_outlines(const std::filesystem::path& file,
                                           std::optional<double> unit);

/// The same from bytes.
std::unique_ptr<OutlineFile> parse_dxf_outlines(std::string_view bytes, const std::string& file,
                                                std::optional<double> unit);
std::unique_ptr<OutlineFile> parse_svg_outlines(std::string_view bytes, const std::string& file,
                                                std::optional<double> unit);

/// Moves the origin of a panel's plane to the middle of its bounding box.
void centre_outline(PatternPanel& panel);

/// [m] by name: "m", "cm", "mm", "in".
std::optional<double> outline_unit(const std::string& name);

}  // namespace weft::io
