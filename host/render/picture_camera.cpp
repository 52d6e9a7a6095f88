#include "host/render/picture_camera.hpp"

#include <algorithm>
#include <cctype>
#include <limits>
#include <string>

#include "host/scene/camera.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace shading {
namespace {

void check_range(const char* field, double value, double low, double high) {
  if (!(value >= low && value <= high))
    throw SceneError("", std::string("picture.") + field, std::to_string(value),
                     std::to_string(low) + " to " + std::to_string(high));
}

/// @throws SceneError if a triangle names a vertex that is not there
Part make_part(const NamedMesh& named) {
  const std::vector<Vec3<double>>& x = named.mesh.positions;
  Part part{&named, {}, {}, {}};
  for (std::size_t i = 0; i < named.mesh.triangles.size(); ++i) {
    const Tri& t = named.mesh.triangles[i];
    bool whole = true;
    for (const Index v : t.v) {
      if (v < 0 || static_cast<std::size_t>(v) >= x.size())
        throw SceneError("", "mesh " + named.name + ", triangle corner", std::to_string(v),
                         "0 or more, and below " + std::to_string(x.size()));
      whole = whole && usable(x[static_cast<std::size_t>(v)]);
    }
    if (!whole) continue;
    part.triangles.push_back(t);
    part.numbers.push_back(i);
  }
  part.for_each_corner([&](const Vec3<double>& p) { part.box.include(p); });
  return part;
}

/// Coordinates along the picture's right, up and depth axes.
Vec3<double> seen(const View& view, const Vec3<double>& d) {
  return {dot(d, view.right), dot(d, view.up), dot(d, view.forward)};
}

/// Place of the eye along picture axis `k` that leaves equal margins on both sides.
/// @param points  as seen()
/// @param depth   of the eye, in front of all points
double centred(const std::vector<Vec3<double>>& points, int k, double depth) {
  double low = points.front()[k], high = low;
  for (const Vec3<double>& p : points) {
    low = std::min(low, p[k]);
    high = std::max(high, p[k]);
  }
  for (int round = 0; round < 40; ++round) {
    const double middle = 0.5 * (low + high);
    double least = 0, most = 0;
    for (const Vec3<double>& p : points) {
      const double slope = (p[k] - middle) / (p[2] - depth);
      least = std::min(least, slope);
      most = std::max(most, slope);
    }
    (most + least > 0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

/// Nearest eye that sees all points: along each picture axis the bounding sight lines of the two
/// sides meet in one place, and the farther of the two places serves both axes.
Vec3<double> fit_eye(const std::vector<Vec3<double>>& world, const View& view, double tan_x,
                     double tan_y) {
  std::vector<Vec3<double>> points;
  for (const Vec3<double>& p : world) points.push_back(seen(view, p - world.front()));
  constexpr double lowest = std::numeric_limits<double>::lowest();
  double right = lowest, left = lowest, top = lowest, bottom = lowest, front = lowest,
         back = lowest;
  for (const Vec3<double>& p : points) {
    right = std::max(right, p[0] - tan_x * p[2]);
    left = std::max(left, -p[0] - tan_x * p[2]);
    top = std::max(top, p[1] - tan_y * p[2]);
    bottom = std::max(bottom, -p[1] - tan_y * p[2]);
    back = std::max(back, p[2]);
    front = std::max(front, -p[2]);
  }
  // A lone point or a line along the view would put the eye into the surface.
  const double clearance = front + 1e-3 * (front + back) + 1e-6;
  const double depth =
      std::min({-(right + left) / (2 * tan_x), -(top + bottom) / (2 * tan_y), -clearance});
  return world.front() + view.right * centred(points, 0, depth) +
         view.up * centred(points, 1, depth) + view.forward * depth;
}

}  // namespace

View::View(const Vec3<double>& eye, const Vec3<double>& look_at, const Vec3<double>& upwards)
    : right(cross(normalized(look_at - eye), normalized(upwards))),
      up{0, 0, 0},
      forward(normalized(look_at - eye)) {
  if (!usable(eye) || !usable(look_at) || !usable(upwards) || eye == look_at ||
      !(length(right) > 1e-9))
    throw SceneError("", "picture.eye, look_at, up", "no view along look_at - eye",
                     "finite, eye and look_at apart from each other, up across the view");
  right = normalized(right);
  up = cross(right, forward);
}

void check_options(const PictureOptions& o) {
  check_range("width", o.width, 1, 16384);
  check_range("height", o.height, 1, 16384);
  check_range("samples", o.samples, 1, 4096);
  check_range("threads", o.threads, 0, 4096);
  check_range("vertical_field_of_view_degrees", o.vertical_field_of_view_degrees, 1, 150);
  check_range("azimuth_degrees", o.azimuth_degrees, -360, 360);
  check_range("elevation_degrees", o.elevation_degrees, -85, 85);
  if (o.ground_height) check_range("ground_height", *o.ground_height, -1e9, 1e9);
}

double half_height(const PictureOptions& o) {
  return std::tan(0.5 * o.vertical_field_of_view_degrees * pi / 180);
}

bool named_like_floor(const Part& part) {
  std::string name = part.source->name;
  for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  for (const char* word : {"plane", "floor", "ground"})
    for (std::size_t at = name.find(word); at != std::string::npos; at = name.find(word, at + 1))
      if (at == 0 || std::isalpha(static_cast<unsigned char>(name[at - 1])) == 0) return true;
  return false;
}

Contents make_contents(const std::vector<NamedMesh>& cloths,
                       const std::vector<NamedMesh>& obstacles, const PictureSubject* subject) {
  Contents c;
  Aabb cloth_box, all;
  const auto frame = [&c](const Part& part) {
    part.for_each_corner([&c](const Vec3<double>& p) {
      c.framed.push_back(p);
      c.framed_box.include(p);
    });
  };
  for (const NamedMesh& m : cloths) {
    c.cloths.push_back(make_part(m));
    c.cloths.back().for_each_corner([&](const Vec3<double>& p) { cloth_box.include(p); });
    frame(c.cloths.back());
  }
  c.cloth_size = std::max(cloth_box.diagonal(), subject != nullptr ? subject->cloth_size : 0);
  all = cloth_box;
  for (const NamedMesh& m : obstacles) {
    c.obstacles.push_back(make_part(m));
    c.obstacles.back().for_each_corner([&](const Vec3<double>& p) { all.include(p); });
    if (!c.is_wide(c.obstacles.back())) frame(c.obstacles.back());
  }
  c.lowest = all.lo[2];
  if (subject != nullptr && !subject->outline.empty()) {
    // All of these are the motion's, whatever this frame shows.
    c.framed = subject->outline;
    c.framed_box = {subject->low, subject->high};
    c.lowest = subject->lowest;
  }
  if (c.framed.empty())
    throw SceneError("", "picture", "no triangle with finite corners", "a frame with a surface");
  return c;
}

PictureOptions framed_options(const Contents& contents, const PictureOptions& options) {
  if (!options.automatic_camera) return options;
  PictureOptions framed = options;
  const double azimuth = options.azimuth_degrees * pi / 180;
  const double elevation = options.elevation_degrees * pi / 180;
  // Azimuth 0 is along x, or along y if x is up.
  const Vec3<double> up = normalized(options.up);
  const Vec3<double> x = std::abs(up[0]) > 0.5 ? Vec3<double>{0, 1, 0} : Vec3<double>{1, 0, 0};
  const Vec3<double> y = cross(up, x);
  const View view(x * (std::cos(azimuth) * std::cos(elevation)) +
                      y * (std::sin(azimuth) * std::cos(elevation)) + up * std::sin(elevation),
                  {0, 0, 0}, up);
  constexpr double used = 0.86;  // share of the picture; the rest is margin
  const double tan_y = used * half_height(options);
  framed.eye = fit_eye(contents.framed, view, tan_y * options.width / options.height, tan_y);
  const Vec3<double> center = contents.framed_box.center();
  framed.look_at = framed.eye + view.forward * dot(center - framed.eye, view.forward);
  framed.up = up;
  // Shadows are caught in a plane of constant z.
  framed.ground = framed.ground && up == Vec3<double>{0, 0, 1};
  framed.automatic_camera = false;
  return framed;
}

const PictureSubject* subject_of(const PictureOptions& options) {
  return options.subject ? &*options.subject : nullptr;
}

}  // namespace shading

void add_to_subject(PictureSubject& subject, const std::vector<NamedMesh>& cloths,
                    const std::vector<NamedMesh>& obstacles) {
  const shading::Contents c = shading::make_contents(cloths, obstacles, nullptr);
  Aabb box = c.framed_box;
  if (!subject.outline.empty()) box.include(subject.low, subject.high);
  subject.lowest = subject.outline.empty() ? c.lowest : std::min(subject.lowest, c.lowest);
  subject.low = box.lo;
  subject.high = box.hi;
  subject.cloth_size = std::max(subject.cloth_size, c.cloth_size);
  // The farthest point in each of many directions, evenly spread (Vogel's spiral on the sphere):
  // as good as all points for a camera that leaves a margin, and few.
  constexpr int directions = 160;
  subject.outline.resize(directions, c.framed.front());
  for (int i = 0; i < directions; ++i) {
    const double z = 1 - (2 * i + 1.0) / directions, r = std::sqrt(1 - z * z);
    const double angle = i * shading::pi * (3 - std::sqrt(5.0));
    const Vec3<double> d{r * std::cos(angle), r * std::sin(angle), z};
    Vec3<double>& farthest = subject.outline[static_cast<std::size_t>(i)];
    for (const Vec3<double>& p : c.framed)
      if (dot(p, d) > dot(farthest, d)) farthest = p;
  }
}

void add_points_to_subject(PictureSubject& subject, const std::vector<Vec3<double>>& points) {
  Aabb box{subject.low, subject.high};
  for (const Vec3<double>& p : points) {
    box.include(p);
    subject.outline.push_back(p);
  }
  subject.low = box.lo;
  subject.high = box.hi;
}

PictureOptions frame_camera(const std::vector<NamedMesh>& cloths,
                            const std::vector<NamedMesh>& obstacles,
                            const PictureOptions& options) {
  shading::check_options(options);
  return shading::framed_options(
      shading::make_contents(cloths, obstacles, shading::subject_of(options)), options);
}

PictureOptions upright(const PictureOptions& options, const Vec3<double>& gravity) {
  int axis = 2;
  for (int k = 0; k < 3; ++k)
    if (std::abs(gravity[k]) > std::abs(gravity[axis])) axis = k;
  PictureOptions result = options;
  result.up = {0, 0, 0};
  result.up[axis] = gravity[axis] > 0 ? -1 : 1;
  return result;
}

PictureOptions with_camera(const PictureOptions& options, const Camera& camera, double time) {
  PictureOptions result = options;
  const Camera unset;
  if (!camera.keys.empty() || camera.width != unset.width || camera.height != unset.height) {
    result.width = camera.width;
    result.height = camera.height;
  }
  if (camera.keys.empty()) return result;
  const CameraKey key = camera_at(camera, time);
  result.automatic_camera = false;
  result.eye = key.position;
  result.look_at = key.look_at;
  result.up = key.up;
  result.vertical_field_of_view_degrees =
      std::clamp(key.field_of_view * 180 / shading::pi, 1.0, 150.0);
  return result;
}

Vec3<double> project_to_picture(const PictureOptions& options, const Vec3<double>& point) {
  shading::check_options(options);
  if (options.automatic_camera)
    throw SceneError("", "picture.automatic_camera", "true", "false: give frame_camera()'s result");
  const shading::View view(options.eye, options.look_at, options.up);
  const Vec3<double> d = shading::seen(view, point - options.eye);
  const double scale = 0.5 * options.height / (shading::half_height(options) * d[2]);
  return {0.5 * options.width + scale * d[0], 0.5 * options.height - scale * d[1], d[2]};
}

}  // namespace weft::io
