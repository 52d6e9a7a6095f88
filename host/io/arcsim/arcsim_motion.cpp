#include "host/io/arcsim/arcsim_motion.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string_view>

#include "host/base/file_bytes.hpp"
#include "host/input/safe_text.hpp"
#include "host/io/json/transform_fields.hpp"
#include "host/io/mesh/mesh_formats.hpp"
#include "host/scene/motion.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

constexpr double pi = std::numbers::pi;
constexpr int pieces = 32;

struct Quaternion {
  double w = 1;
  Vec3<double> v{0, 0, 0};
};

Quaternion quaternion_of(const Transform& t) {
  return {std::cos(t.rotation_angle / 2), t.rotation_axis * std::sin(t.rotation_angle / 2)};
}

Quaternion product(const Quaternion& a, const Quaternion& b) {
  return {a.w * b.w - dot(a.v, b.v), b.v * a.w + a.v * b.w + cross(a.v, b.v)};
}

/// Sets the rotation of `transform`, with an angle in [0, pi].
/// @pre q is not zero
void set_rotation(Transform& transform, Quaternion q) {
  if (q.w < 0) q = {-q.w, -q.v};
  const double sine = length(q.v);
  transform.rotation_angle = 2 * std::atan2(sine, q.w);
  transform.rotation_axis = sine > 0 ? q.v * (1.0 / sine) : Vec3<double>{0, 0, 1};
}

/// Of all rotation vectors of one rotation, the one nearest to `previous`: motions interpolate the
/// vectors.
void unwind(Transform& transform, const Transform& previous) {
  const Vec3<double> before = rotation_vector(previous);
  const double turns =
      std::round((dot(transform.rotation_axis, before) - transform.rotation_angle) / (2 * pi));
  Vec3<double> vector = transform.rotation_axis * (transform.rotation_angle + 2 * pi * turns);
  set_rotation_vector(transform, vector);
}

using Parameters = Vec<double, 7>;

Parameters parameters_of(const Transform& t) {
  const Vec3<double> r = rotation_vector(t);
  return {t.translate[0], t.translate[1], t.translate[2], r[0], r[1], r[2], t.scale};
}

Transform transform_of(const Parameters& p) {
  Transform t;
  t.translate = {p[0], p[1], p[2]};
  set_rotation_vector(t, {p[3], p[4], p[5]});
  t.scale = p[6];
  return t;
}

/// Keys with slopes, as keys without: dense enough for Catmull-Rom slopes to come out the same.
Motion divided(const Motion& motion, const std::vector<std::optional<Parameters>>& given) {
  std::vector<Parameters> slope(motion.size());
  for (std::size_t k = 0; k < motion.size(); ++k) {
    if (given[k]) {
      slope[k] = *given[k];
    } else if (k > 0 && k + 1 < motion.size()) {
      slope[k] = (parameters_of(motion[k + 1].transform) - parameters_of(motion[k - 1].transform)) *
                 (1.0 / (motion[k + 1].time - motion[k - 1].time));
    }
  }
  Motion dense;
  for (std::size_t k = 0; k + 1 < motion.size(); ++k) {
    const double span = motion[k + 1].time - motion[k].time;
    const Parameters a = parameters_of(motion[k].transform);
    const Parameters b = parameters_of(motion[k + 1].transform);
    dense.push_back(motion[k]);
    for (int i = 1; i < pieces; ++i) {
      const double s = static_cast<double>(i) / pieces;
      const double s2 = s * s;
      const double s3 = s2 * s;
      dense.push_back(
          {motion[k].time + s * span,
           transform_of(a + (b - a) * (3 * s2 - 2 * s3) + slope[k] * ((s3 - 2 * s2 + s) * span) +
                        slope[k + 1] * ((s3 - s2) * span))});
    }
  }
  dense.push_back(motion.back());
  return dense;
}

bool only_translates(const Motion& motion) {
  return std::all_of(motion.begin(), motion.end(), [&](const Keyframe& key) {
    return key.transform.rotation_angle == 0 &&
           key.transform.scale == motion.front().transform.scale;
  });
}

/// Lines of numbers of a .mot file.
class MotReader {
 public:
  MotReader(std::string_view bytes, const std::string& file) : rest_(bytes), file_(file) {}

  std::vector<Motion> read(double frame_rate, const Transform& placement) {
    std::string_view line;
    if (!next_line(line) || !line.starts_with("NumFrames:")) refuse(line, "NumFrames: N");
    line.remove_prefix(std::string_view("NumFrames:").size());
    const double count = numbers<1>(line)[0];
    // A frame takes 14 bytes at least: seven numbers, and what parts them.
    if (!(count >= 1 && count == std::floor(count) &&
          count <= static_cast<double>(rest_.size()) / 14 + 1))
      refuse(line, "a whole number of frames that the file can hold");
    const auto frames = static_cast<std::size_t>(count);
    std::vector<Motion> motions;
    while (next_line(line)) {  // a line such as "body[0] position"
      Motion motion(frames);
      for (std::size_t k = 0; k < frames; ++k) {
        motion[k].time = static_cast<double>(k) / frame_rate;
        motion[k].transform.translate = numbers<3>(required_line());
      }
      (void)required_line();
      for (std::size_t k = 0; k < frames; ++k) {
        const Vec<double, 4> q = numbers<4>(required_line());
        const double size = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
        if (!(size > 1e-12) || !std::isfinite(size)) refuse("quaternion", "one that is not zero");
        Transform& t = motion[k].transform;
        set_rotation(t, {q[0] / size, Vec3<double>{q[1], q[2], q[3]} * (1.0 / size)});
        t = composed(placement, t);
        if (k > 0) unwind(t, motion[k - 1].transform);
      }
      if (frames == 1) motion.push_back({1 / frame_rate, motion.front().transform});
      motions.push_back(std::move(motion));
    }
    if (motions.empty()) refuse("no bodies", "at least one body");
    return motions;
  }

 private:
  [[noreturn]] void refuse(std::string_view value, const std::string& allowed) const {
    throw SceneError(file_, "line " + std::to_string(line_number_), quoted_start(value), allowed);
  }

  /// The next line that is not blank.
  bool next_line(std::string_view& line) {
    while (!rest_.empty()) {
      ++line_number_;
      const std::size_t end = std::min(rest_.find('\n'), rest_.size());
      line = rest_.substr(0, end);
      rest_.remove_prefix(std::min(end + 1, rest_.size()));
      if (line.find_first_not_of(" \t\r") != std::string_view::npos) return true;
    }
    return false;
  }

  std::string_view required_line() {
    std::string_view line;
    if (!next_line(line)) refuse("end of file", "a position and a quaternion a frame and body");
    return line;
  }

  template <int N>
  Vec<double, N> numbers(std::string_view line) const {
    const std::string_view whole = line;
    Vec<double, N> values{};
    for (int k = 0;; ++k) {
      const std::size_t begin = std::min(line.find_first_not_of(" \t\r"), line.size());
      if (begin == line.size()) {
        if (k == N) return values;
        refuse(whole, std::to_string(N) + " numbers");
      }
      const std::size_t end = std::min(line.find_first_of(" \t\r", begin), line.size());
      if (k == N || !parse_number(line.substr(begin, end - begin), values[k]) ||
          !std::isfinite(values[k]))
        refuse(whole, std::to_string(N) + " finite numbers");
      line.remove_prefix(end);
    }
  }

  std::string_view rest_;
  const std::string& file_;
  std::size_t line_number_ = 0;
};

}  // namespace

Transform read_arcsim_transform(Fields& fields, const std::string& key) {
  Fields transform = fields.object(key, transform_keys());
  return read_transform(transform);
}

Transform composed(const Transform& outer, const Transform& inner) {
  Transform result;
  set_rotation(result, product(quaternion_of(outer), quaternion_of(inner)));
  result.scale = outer.scale * inner.scale;
  result.translate = apply(outer, inner.translate);
  return result;
}

Motion composed(const Motion& motion, const Transform& inner) {
  const bool only_scales = inner.rotation_angle == 0 && length(inner.translate) == 0;
  Motion result = only_scales || only_translates(motion)
                      ? motion
                      : divided(motion, std::vector<std::optional<Parameters>>(motion.size()));
  for (std::size_t k = 0; k < result.size(); ++k) {
    Transform& t = result[k].transform;
    if (only_scales) {
      t.scale *= inner.scale;  // the turns stay as they were written
      continue;
    }
    t = composed(t, inner);
    if (k > 0) unwind(t, result[k - 1].transform);
  }
  return result;
}

Motion read_arcsim_keys(std::vector<Fields>& keys) {
  Motion motion;
  std::vector<std::optional<Parameters>> slopes;
  bool any_slope = false;
  for (Fields& fields : keys) {
    Keyframe key;
    key.time = fields.number("time");
    if (!motion.empty() && !(key.time > motion.back().time))
      fields.refuse("time", "times that increase from key to key");
    key.transform = read_arcsim_transform(fields, "transform");
    motion.push_back(key);
    slopes.emplace_back();
    if (!fields.has("velocity")) continue;
    // A rate: nothing at all for the parts that are not given, the scale too.
    Fields rate = fields.object("velocity", transform_keys());
    const Vec3<double> move = rate.vector<3>("translate", Vec3<double>{0, 0, 0});
    Transform turn;
    read_rotation(rate, turn);
    const Vec3<double> r = rotation_vector(turn);
    slopes.back() =
        Parameters{move[0], move[1], move[2], r[0], r[1], r[2], rate.number("scale", 0.0)};
    any_slope = true;
  }
  if (motion.size() == 1) {
    motion.push_back(motion.front());
    motion.back().time += 1;
    return motion;
  }
  return any_slope ? divided(motion, slopes) : motion;
}

std::vector<Motion> read_mot(const std::filesystem::path& path, double frame_rate,
                             const Transform& placement) {
  const std::string file = path.string();
  const std::string bytes = read_file_bytes(path);
  return MotReader(bytes, file).read(frame_rate, placement);
}

nlohmann::json transform_json(const Transform& t) {
  const auto& x = t.translate;
  const auto& axis = t.rotation_axis;
  return {{"translate", {x[0], x[1], x[2]}},
          {"rotate", {t.rotation_angle * (180 / pi), axis[0], axis[1], axis[2]}},
          {"scale", t.scale}};
}

nlohmann::json motion_json(const Motion& motion) {
  nlohmann::json keys = nlohmann::json::array();
  for (const Keyframe& key : motion) {
    keys.push_back(transform_json(key.transform));
    keys.back()["time"] = key.time;
  }
  return keys;
}

}  // namespace weft::io
