#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

namespace weft::io {

/// Picture of 8-bit colours, row by row from the top left: rgb[3 * (y * width + x) + channel],
/// gamma-encoded.
struct Image {
  int width = 0;                  ///< [pixels]
  int height = 0;                 ///< [pixels]
  std::vector<std::uint8_t> rgb;  ///< [3 * width * height]
};

/// Writes `image` as PNG (8-bit RGB). The file appears whole or not at all: it is written beside
/// its place and then renamed, so whoever watches `path` never reads half a picture. Folders are
/// not made.
/// @param path  file to write or replace
/// @throws SceneError naming the file if the image is inconsistent (a size below 1, or rgb of
///         another length than 3 * width * height) or the file cannot be written; then `path` is
///         as it was before
void write_png(const std::filesystem::path& path, const Image& image);

}  // namespace weft::io
