#pragma once

#include <map>
#include <optional>
#include <string>

#include "host/io/animation/bvh_file.hpp"
#include "host/model/skinning.hpp"

/// A body for motion capture, which has a skeleton only: a capsule along every bone.
namespace weft::io {

struct CaptureBody {
  bool y_up = true;                     ///< of the file; false: z up
  double scale = 1;                     ///< [m] a unit of the file
  std::optional<double> radius;         ///< [m] of all bones; nothing: default_radius()
  std::map<std::string, double> radii;  ///< [m] by name of the joint that a bone starts from
  double edge = 0.02;                   ///< [m] length of edges that is aimed at, > 0
  std::size_t first_frame = 0;
  std::size_t last_frame = 0;  ///< included
};

/// Most triangles of a body; longer edges are taken if there would be more.
inline constexpr double max_body_triangles = 40000;

/// How tall the skeleton stands as its offsets put it together, without any thickness.
/// @return [units of the file]
double capture_height(const Capture& capture, bool y_up);

/// Radius of a bone of a grown body by what it is called: "LeftUpLeg", "r_forearm", "Spine1";
/// whatever has another name is a fifth as thick as long.
/// @param name   of the joint that it starts from
/// @param length [m]
/// @param size   [m] of the body, head to toe
/// @return       [m]
double default_radius(const std::string& name, double length, double size);

/// A capsule along every bone, that is from every joint to each joint or end site below it, hung on
/// the joint. Each is a closed surface of its own; they overlap. Capsules end in half a sphere
/// around the joints, but at end sites, which lie on the skin, the half sphere ends there. Bones
/// shorter than 1/400 of the body have none. Positions are linear between frames, rotations go on
/// the shortest arc.
/// @param file for messages
/// @pre first_frame <= last_frame < capture.frame_count
/// @throws SceneError if no bone is left, or if bones are too thin to be meshed
SkinnedSurface make_capture_body(const Capture& capture, const CaptureBody& body,
                                 const std::string& file);

}  // namespace weft::io
