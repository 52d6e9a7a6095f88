#include <algorithm>
#include <memory>
#include <set>
#include <utility>

#include "host/geometry/mesh_check.hpp"
#include "host/io/animation/bvh_file.hpp"
#include "host/io/animation/capture_body.hpp"
#include "host/io/animation/mesh_sequence.hpp"
#include "host/io/animation/sequence_file.hpp"
#include "host/io/animation/skinned_file.hpp"
#include "host/io/scene/file_axes.hpp"
#include "host/io/scene/scene_parts.hpp"
#include "host/io/usd/surface_file.hpp"
#include "weft/error.hpp"

/// Obstacles that change their shape.
namespace weft::io {
namespace {

/// Height of a body for which neither height nor scale is given.
constexpr double default_height = 1.7;

Playback read_playback(Fields& fields) {
  Playback playback;
  playback.start_time = fields.number("start_time", quantity::instant, playback.start_time);
  playback.speed = fields.number("speed", quantity::speed_factor, playback.speed);
  playback.loop = fields.boolean("loop", playback.loop);
  return playback;
}

bool read_y_up(Fields& obstacle, bool usual) {
  return obstacle.choice("up", {"y", "z"}, usual ? 0 : 1) == 0;
}

/// Shape at time 0 and how it changes.
/// @param file for messages
void set_shape(std::vector<Tri> triangles, std::size_t vertices,
               std::shared_ptr<const Deformation> deformation, const std::string& file,
               Obstacle& obstacle) {
  obstacle.mesh.triangles = std::move(triangles);
  obstacle.mesh.positions.resize(vertices);
  deformation->positions(0, obstacle.mesh.positions);
  obstacle.deformation = std::move(deformation);
  check_mesh(obstacle.mesh, {file, "mesh", ""}, false);
}

bool has_number_place(const std::filesystem::path& pattern) {
  try {
    return NumberedName(pattern.filename().string()).has_place();
  } catch (const SceneError&) {
    return false;
  }
}

void read_sequence(Fields& obstacle_fields, const ReadableFolders& folders, Obstacle& obstacle) {
  Fields fields =
      obstacle_fields.object("sequence", {"files", "mesh", "points", "first", "last", "frame_rate",
                                          "interpolation", "start_time", "speed", "loop"});
  SequenceChoice choice;
  std::filesystem::path usd;  // the file, if it is one of USD
  if (fields.has("files") && is_usd_file(fields.text("files")) &&
      !has_number_place(fields.text("files"))) {
    usd = read_path(fields, "files", folders);
    choice.frame_rate = UsdFile(usd).frame_rate();
  }
  choice.frame_rate = fields.number("frame_rate", quantity::rate, choice.frame_rate);
  choice.interpolation = fields.choice("interpolation", {"cubic", "linear"}, 0) == 0
                             ? Interpolation::cubic
                             : Interpolation::linear;
  if (usd.empty()) choice.y_up = read_y_up(obstacle_fields, choice.y_up);
  choice.playback = read_playback(fields);
  choice.first = static_cast<int>(fields.integer("first", 0, 0, 100'000'000));
  if (fields.has("last"))
    choice.last = static_cast<int>(fields.integer("last", {}, choice.first, 100'000'000));
  SampledSurface surface;
  std::string file;
  if (fields.one_of({"files", "points"}) == "files") {
    if (fields.has("mesh")) fields.refuse("mesh", "only with points, files are meshes already");
    if (!usd.empty() && obstacle_fields.has("up"))
      obstacle_fields.refuse("up", "nothing beside a USD file, which says it itself");
    const std::filesystem::path pattern = resolved_path(fields, fields.text("files"));
    if (usd.empty() && !has_number_place(pattern))
      fields.refuse("files",
                    "a name with one place for a number, such as body_%04d.obj, or a .usda");
    folders.require(pattern, fields.file(), fields.path_of("files"));
    fields.record("files", pattern.string());
    file = pattern.string();
    surface =
        usd.empty() ? read_mesh_sequence(pattern, choice, folders) : read_usd_sequence(usd, choice);
  } else {
    const std::filesystem::path points = read_path(fields, "points", folders);
    file = points.string();
    surface =
        read_point_cache_sequence(read_path(fields, "mesh", folders), points, choice, folders);
  }
  const std::size_t vertices = surface.deformation->vertex_count();
  fields.record("last",
                choice.first + static_cast<std::int64_t>(surface.deformation->frame_count()) - 1);
  set_shape(std::move(surface.triangles), vertices, std::move(surface.deformation), file, obstacle);
}

void read_skinned_body(Fields& obstacle_fields, const ReadableFolders& folders, Scene& scene,
                       Obstacle& obstacle) {
  Fields fields =
      obstacle_fields.object("skinned", {"file", "animation", "start_time", "speed", "loop"});
  SkinnedChoice choice;
  if (fields.is_text("animation"))
    choice.name = fields.text("animation");
  else
    choice.animation = static_cast<int>(fields.integer("animation", 0, 0, 1'000'000));
  const FileAxes axes = read_file_axes(obstacle_fields, {choice.scale, choice.y_up});
  choice.y_up = axes.y_up;
  choice.scale = axes.unit;
  const Playback playback = read_playback(fields);
  const std::filesystem::path path = read_path(fields, "file", folders);
  SkinnedSurface surface = read_skinned(path, choice, scene.warnings, folders);
  const std::size_t vertices = surface.skin.rest.size();
  set_shape(std::move(surface.triangles), vertices,
            std::make_shared<SkinnedDeformation>(std::move(surface.skin), playback), path.string(),
            obstacle);
}

/// One radius for all bones, or a table of them.
void read_radii(Fields& fields, const Capture& capture, CaptureBody& body) {
  if (!fields.has("radius")) return;
  if (!fields.is_object("radius")) {
    body.radius = fields.number("radius", quantity::length);
    return;
  }
  std::vector<std::string> names;
  std::set<std::string> known;
  for (const CaptureJoint& joint : capture.joints)
    if (!joint.end_site && known.insert(joint.name).second) names.push_back(joint.name);
  Fields table = fields.object("radius", names);
  for (const std::string& name : table.present_keys())
    body.radii[name] = table.number(name, quantity::length);
}

/// Metres a unit, from the obstacle's units or from how tall the body is to be.
double read_capture_scale(Fields& obstacle, Fields& fields, const Capture& capture, bool y_up) {
  if (obstacle.has("units")) {
    if (fields.has("height")) fields.refuse("height", "units of the obstacle or height, not both");
    return read_file_axes(obstacle, {1, y_up}).unit;
  }
  const double height = fields.number("height", quantity::length, default_height);
  const double scale = height / capture_height(capture, y_up);
  if (!quantity::scale.holds(scale))
    fields.refuse("height",
                  "units of the obstacle instead, as the skeleton's offsets have no height");
  return scale;
}

void read_capture(Fields& obstacle_fields, const ReadableFolders& folders, double edge,
                  Obstacle& obstacle) {
  Fields fields = obstacle_fields.object(
      "capture", {"file", "height", "radius", "first", "last", "start_time", "speed", "loop"});
  const std::filesystem::path path = read_path(fields, "file", folders);
  const Capture capture = read_bvh(path);
  CaptureBody body;
  body.y_up = read_y_up(obstacle_fields, body.y_up);
  body.scale = read_capture_scale(obstacle_fields, fields, capture, body.y_up);
  read_radii(fields, capture, body);
  body.edge = std::clamp(edge, quantity::least_length, quantity::most_length);
  const auto last = static_cast<std::int64_t>(capture.frame_count) - 1;
  body.first_frame = static_cast<std::size_t>(fields.integer("first", 0, 0, last));
  body.last_frame = static_cast<std::size_t>(
      fields.integer("last", last, static_cast<std::int64_t>(body.first_frame), last));
  const Playback playback = read_playback(fields);
  SkinnedSurface surface = make_capture_body(capture, body, path.string());
  const std::size_t vertices = surface.skin.rest.size();
  set_shape(std::move(surface.triangles), vertices,
            std::make_shared<SkinnedDeformation>(std::move(surface.skin), playback), path.string(),
            obstacle);
}

}  // namespace

void read_body(Fields& fields, const std::string& kind, const ReadableFolders& folders, double edge,
               Scene& scene, Obstacle& obstacle) {
  if (kind == "sequence") read_sequence(fields, folders, obstacle);
  if (kind == "skinned") read_skinned_body(fields, folders, scene, obstacle);
  if (kind == "capture") read_capture(fields, folders, edge, obstacle);
}

}  // namespace weft::io
