#include "host/scene/camera.hpp"

#include <algorithm>
#include <cstddef>
#include <numbers>
#include <vector>

#include "host/input/checker.hpp"
#include "weft/core/assert.hpp"
#include "weft/error.hpp"

namespace weft {
namespace {

constexpr double degree = std::numbers::pi / 180;
/// Of a jump: frames stand at number / rate, which need not be the double that the scene names.
constexpr double time_tolerance = 1e-9;

/// One key as the vector that is interpolated.
using CameraParameters = Vec<double, 10>;

CameraParameters parameters_of(const CameraKey& key) {
  const Vec3<double>&p = key.position, &a = key.look_at, &u = key.up;
  return {p[0], p[1], p[2], a[0], a[1], a[2], u[0], u[1], u[2], key.field_of_view};
}

/// Catmull-Rom slope at a key [per second]; zero at the first and the last of a take.
CameraParameters slope_at(const std::vector<CameraKey>& keys, std::size_t k) {
  if (k == 0 || k + 1 == keys.size() || keys[k].jump || keys[k + 1].jump) return {};
  return (parameters_of(keys[k + 1]) - parameters_of(keys[k - 1])) *
         (1.0 / (keys[k + 1].time - keys[k - 1].time));
}

CameraKey held(CameraKey key, double time) {
  key.time = time;
  return key;
}

std::string vector_text(const Vec3<double>& v) {
  return "[" + text_of(v[0]) + ", " + text_of(v[1]) + ", " + text_of(v[2]) + "]";
}

void validate_key(const CameraKey& key, const std::string& file, const std::string& field) {
  const Checker check(file, field);
  check.within("position", key.position, quantity::coordinate);
  check.within("look_at", key.look_at, quantity::coordinate);
  check.within("up", key.up, quantity::coordinate);
  const double angle = key.field_of_view / degree;
  if (!(angle >= 1 - 1e-9 && angle <= 150 + 1e-9))
    throw SceneError(file, field + ".field_of_view", text_of(angle), "1 to 150 degrees");
  const Vec3<double> view = key.look_at - key.position;
  if (!(length(view) > 0))
    throw SceneError(file, field + ".look_at", vector_text(key.look_at),
                     "a point other than position");
  if (!(length(key.up) > 0))
    throw SceneError(file, field + ".up", vector_text(key.up), "a direction that is not zero");
  const Vec3<double> across = cross(view * (1 / length(view)), key.up * (1 / length(key.up)));
  if (!(length(across) > 1e-6))
    throw SceneError(file, field + ".up", vector_text(key.up), "a direction across the view");
}

void validate_view_settings(const Scene& scene) {
  const ViewSettings& v = scene.view;
  const Checker check(scene.file, "method.view");
  check.within("factor_back", v.factor_back, quantity::positive_share);
  check.within("factor_out", v.factor_out, quantity::positive_share);
  check.within("margin", v.margin, quantity::length_or_zero);
  check.within("anticipation", v.anticipation, quantity::frames_ahead);
  check.within("transfer_threshold", v.transfer_threshold, quantity::share);
  check.within("pixel_min", v.pixel_min, quantity::pixels);
  check.within("compensation_power", v.compensation_power, quantity::exponent);
}

}  // namespace

CameraKey camera_at(const Camera& camera, double time) {
  const std::vector<CameraKey>& keys = camera.keys;
  WEFT_ASSERT(!keys.empty());
  const auto next = std::upper_bound(
      keys.begin(), keys.end(), time,
      [](double t, const CameraKey& key) { return t + time_tolerance < key.time; });
  if (next == keys.begin()) return held(keys.front(), time);
  const auto i1 = static_cast<std::size_t>(next - keys.begin());
  const CameraKey& k0 = keys[i1 - 1];
  if (i1 == keys.size() || keys[i1].jump) return held(k0, time);
  const double span = keys[i1].time - k0.time;
  const double s = std::max(0.0, (time - k0.time) / span);
  const double s2 = s * s;
  const double s3 = s2 * s;
  const CameraParameters p0 = parameters_of(k0);
  const CameraParameters p = p0 + (parameters_of(keys[i1]) - p0) * (3 * s2 - 2 * s3) +
                             slope_at(keys, i1 - 1) * ((s3 - 2 * s2 + s) * span) +
                             slope_at(keys, i1) * ((s3 - s2) * span);
  CameraKey key = held(k0, time);
  key.position = {p[0], p[1], p[2]};
  key.look_at = {p[3], p[4], p[5]};
  key.up = {p[6], p[7], p[8]};
  // The curve may overshoot its keys.
  key.field_of_view = std::clamp(p[9], degree, 150 * degree);
  return key;
}

void validate_camera(const Camera& camera, const std::string& file) {
  for (const auto& [size, place] : {std::pair{camera.width, "[0]"}, {camera.height, "[1]"}})
    if (size < 1 || size > 16384)
      throw SceneError(file, std::string("camera.resolution") + place, std::to_string(size),
                       "an integer from 1 to 16384");
  for (std::size_t k = 0; k < camera.keys.size(); ++k) {
    const std::string field = "camera.keys[" + std::to_string(k) + "]";
    const double time = camera.keys[k].time;
    Checker(file, field).within("time", time, quantity::instant);
    if (k > 0 && !(time - camera.keys[k - 1].time >= quantity::least_time))
      throw SceneError(
          file, field + ".time", text_of(time),
          "times that increase from key to key, here > " + text_of(camera.keys[k - 1].time));
    validate_key(camera.keys[k], file, field);
  }
}

void validate_view(const Scene& scene) {
  validate_view_settings(scene);
  const bool slices = slices_remesh(scene) && scene.time_parallel.method == "view";
  if (scene.method != "view" && !slices) return;
  const std::vector<CameraKey>& keys = scene.camera.keys;
  const std::string with = ", with the method \"view\"";
  if (keys.empty()) throw SceneError(scene.file, "camera.keys", "none", "at least one key" + with);
  if (keys.size() == 1) return;
  // A take of one key, before or after a cut, is a camera at rest.
  const double slack = 1e-6 / scene.time.frame_rate;
  const double end = scene.time.frames / scene.time.frame_rate;
  if (!keys[1].jump && keys.front().time > slack)
    throw SceneError(scene.file, "camera.keys",
                     "a track that begins at " + text_of(keys.front().time) + " s",
                     "one that begins at 0 s" + with);
  if (!keys.back().jump && keys.back().time < end - slack)
    throw SceneError(scene.file, "camera.keys",
                     "a track that ends at " + text_of(keys.back().time) + " s",
                     "one that lasts as long as the run, " + text_of(end) + " s" + with);
}

}  // namespace weft
