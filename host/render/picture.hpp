#pragma once

#include <optional>
#include <vector>

#include "host/io/mesh/mesh_file.hpp"
#include "host/render/png_file.hpp"
#include "weft/core/vec.hpp"

namespace weft::io {

/// What the pictures of one motion have in common, so that camera, floor and light hold still.
struct PictureSubject {
  Vec3<double> low{0, 0, 0}, high{0, 0, 0};  ///< [m] box of what must be seen
  double cloth_size = 0;                     ///< [m] diagonal of the cloths' box, the largest
  double lowest = 0;                         ///< [m] lowest point
  std::vector<Vec3<double>> outline;  ///< [m] points about what must be seen; empty: none yet
};

/// Takes one more frame into account.
/// @throws SceneError if a triangle names a vertex that is not there, or there is nothing to see
void add_to_subject(PictureSubject& subject, const std::vector<NamedMesh>& cloths,
                    const std::vector<NamedMesh>& obstacles);

/// Numbers that colour the cloths, in place of a hue a cloth; see colour_of().
struct PictureValues {
  std::vector<std::vector<float>> corners;  ///< [cloth][3 * triangles]; not finite: no value, grey
  double low = 0, high = 1;                 ///< ends of the colour map, low < high
};

/// A thin black line in the world, as wide as those of edges.
struct Wire {
  Vec3<double> from, to;  ///< [m]
};

/// How a picture is taken. z is up.
struct PictureOptions {
  int width = 1280;                            ///< [pixels] 1..16384
  int height = 960;                            ///< [pixels] 1..16384
  int samples = 16;                            ///< camera rays a pixel, 1..4096
  bool automatic_camera = true;                ///< eye and look_at come from the meshes
  Vec3<double> eye{0, 0, 0};                   ///< [m] read if automatic_camera is off
  Vec3<double> look_at{0, 0, 0};               ///< [m] read if automatic_camera is off
  Vec3<double> up{0, 0, 1};                    ///< any length; an axis for the automatic camera
  double vertical_field_of_view_degrees = 35;  ///< 1..150
  double azimuth_degrees = -60;         ///< automatic camera: where the eye stands, seen from
                                        ///< above, counter-clockwise from +x
  double elevation_degrees = 22;        ///< automatic camera: above the horizon, -85..85
  bool ground = true;                   ///< catch shadows below the lowest point, unless an
                                        ///< obstacle is named like a floor
  std::optional<double> ground_height;  ///< [m] instead of the lowest point
  bool edges = false;                   ///< thin lines along the edges of the cloths' triangles
  bool coloured_edges = false;          ///< values colour these lines, and the cloth but faintly
  std::vector<Wire> wires;              ///< hidden by whatever is in front of them
  /// What the motion shows, for an automatic camera and for all that must not change from frame to
  /// frame; nothing: the frame by itself.
  std::optional<PictureSubject> subject;
  int threads = 0;  ///< 0: all; the picture does not depend on it
};

/// Takes points into account that are no part of a mesh.
/// @pre add_to_subject() has been called
void add_points_to_subject(PictureSubject& subject, const std::vector<Vec3<double>>& points);

/// `options` with that axis up against which gravity acts: y in scenes that are made with y up. z
/// without gravity.
PictureOptions upright(const PictureOptions& options, const Vec3<double>& gravity);

/// Fills in eye and look_at so that all that counts is inside the picture with a margin, and
/// turns automatic_camera off. What counts: all cloths, and the obstacles that are not much
/// larger than they are, as floors and walls may be. Give it the meshes of several frames at once
/// to get one camera that holds still for all of them.
/// @return `options` unchanged if automatic_camera is off
/// @throws SceneError if an option is out of range, or no triangle has three finite corners
PictureOptions frame_camera(const std::vector<NamedMesh>& cloths,
                            const std::vector<NamedMesh>& obstacles, const PictureOptions& options);

/// `options` with the camera of a scene, its resolution too; unchanged if the scene has neither.
/// @param time [s]
/// @pre the camera has passed validate()
PictureOptions with_camera(const PictureOptions& options, const Camera& camera, double time);

/// Where a point appears in the picture.
/// @param options  with automatic_camera off, such as frame_camera() returns
/// @param point    [m]
/// @return {x [pixels] from the left, y [pixels] from the top, depth [m] along the view; x and y
///         hold only where depth > 0}
/// @throws SceneError if an option is out of range
Vec3<double> project_to_picture(const PictureOptions& options, const Vec3<double>& point);

/// Shades one frame: smooth two-sided cloth, each cloth in a hue of its own by its place in the
/// list, warm grey obstacles, a soft key light, a cool fill, light from the near surroundings, and
/// a ground that shows only its shadows. The same input gives the same bytes on one machine and
/// build, for any number of threads. Triangles with a corner that is not finite are skipped.
/// @param values colours of the cloths; null: a hue a cloth. Coloured cloth is lit by white light
///               alone, so that its colours are those of the map
/// @throws SceneError if an option is out of range, a triangle names a vertex that is not there,
///         nothing is left to show, or there are more or fewer values than corners
/// @throws DeviceError if the ray tracer cannot start
Image render_picture(const std::vector<NamedMesh>& cloths, const std::vector<NamedMesh>& obstacles,
                     const PictureOptions& options, const PictureValues* values = nullptr);

}  // namespace weft::io
