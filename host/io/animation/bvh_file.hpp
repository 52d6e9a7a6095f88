#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "weft/core/ids.hpp"
#include "weft/core/vec.hpp"

/// Motion capture in Biovision's BVH format: a skeleton of joints, and a number for each of their
/// channels in each frame.
namespace weft::io {

struct CaptureChannel {
  bool rotation = true;  ///< [degrees]; false: position [units of the file]
  int axis = 0;          ///< 0, 1, 2: x, y, z
};

struct CaptureJoint {
  std::string name;       ///< of an end site: that of its joint
  Index parent = -1;      ///< number of an earlier joint; -1: a root
  bool end_site = false;  ///< the tip of the last bone of a limb, without channels
  Vec3<double> offset{};  ///< [units of the file] from the parent, where no channel says else
  std::size_t first_channel = 0;  ///< place of the first channel in a frame
  /// In the order of the file. Rotations apply in this order to the frame, so the last of them to
  /// a point first; a position takes the place of the offset's coordinate.
  std::vector<CaptureChannel> channels;
};

struct Capture {
  std::vector<CaptureJoint> joints;  ///< parents before their children
  std::size_t channel_count = 0;
  std::size_t frame_count = 0;
  double frame_time = 0;       ///< [s] > 0
  std::vector<double> values;  ///< [frames][channels]

  double value(std::size_t frame, std::size_t channel) const {
    return values[frame * channel_count + channel];
  }
};

/// Keywords in any case, channels in any order and number, names with spaces, several roots. What
/// stands after the last of the frames that the file claims is ignored: takes that were cut short
/// by hand are common.
/// @param file for messages
/// @return at least one joint and one frame, all numbers finite
/// @throws SceneError with the line
Capture parse_bvh(std::string_view bytes, const std::string& file);

/// parse_bvh() of a file's content.
/// @throws SceneError also if it cannot be read
Capture read_bvh(const std::filesystem::path& path);

}  // namespace weft::io
