#include "host/render/picture.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <thread>
#include <vector>

#include "host/render/picture_camera.hpp"
#include "host/render/picture_colour.hpp"
#include "host/render/picture_scene.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

using namespace shading;

// ---------------------------------------------------------------- sample positions

/// Mixes 64 bits so that neighbouring pixels get unrelated patterns (finalizer of splitmix64).
std::uint64_t mixed(std::uint64_t z) {
  z += 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

struct Point2 {
  float x, y;
};

/// Points that fill the unit disc evenly (Vogel's spiral), the same for every pixel but turned.
/// Each use of a pixel takes them in an order of its own, so that no use follows another one.
class Samples {
 public:
  static constexpr unsigned uses = 3;

  explicit Samples(unsigned count) {
    for (unsigned i = 0; i < count; ++i) {
      const double angle = i * pi * (3 - std::sqrt(5.0)), r = std::sqrt((i + 0.5) / count);
      disc_.push_back(
          {static_cast<float>(r * std::cos(angle)), static_cast<float>(r * std::sin(angle))});
    }
  }

  unsigned count() const { return static_cast<unsigned>(disc_.size()); }

  /// What is fixed for a pixel: a turn and a start a use.
  struct Pixel {
    std::array<Point2, uses> turn;
    std::array<unsigned, uses> start;
    float phase;  ///< 0..1
  };

  static Pixel pixel(std::uint64_t number) {
    Pixel p{};
    for (unsigned use = 0; use < uses; ++use) {
      const std::uint64_t key = mixed(number * uses + use);
      const float angle = static_cast<float>(key >> 40) * (0x1p-24f * 2 * static_cast<float>(pi));
      p.turn[use] = {std::cos(angle), std::sin(angle)};
      p.start[use] = static_cast<unsigned>(key & 0xffff);
      p.phase = static_cast<float>((key >> 16) & 0xffff) * 0x1p-16f;
    }
    return p;
  }

  /// Point `i` of a use. The strides are primes above any count, so that all points are met.
  Point2 disc(const Pixel& p, unsigned use, unsigned i) const {
    constexpr std::array<unsigned, uses> stride{1, 4099, 5003};
    const Point2 d = disc_[(i * stride[use] + p.start[use]) % disc_.size()];
    const Point2 t = p.turn[use];
    return {d.x * t.x - d.y * t.y, d.x * t.y + d.y * t.x};
  }

  /// Evenly spread over 0..1.
  float line(const Pixel& p, unsigned i) const {
    const float u = p.phase + static_cast<float>(i) * 0.61803399f;
    return u - std::floor(u);
  }

 private:
  std::vector<Point2> disc_;
};

/// Random points of one camera ray.
struct Draw {
  Point2 light, around;
  float reach;
};

/// Cosine-weighted direction about `normal`.
Float3 cosine_direction(const Float3& normal, Point2 d) {
  const Frame f(normal);
  return f.x * d.x + f.y * d.y + f.z * std::sqrt(std::max(0.0f, 1 - d.x * d.x - d.y * d.y));
}

// ---------------------------------------------------------------- light

/// Directions and strengths of the lights, in the world but turned with the camera.
struct Lights {
  Frame key;         ///< third axis towards the light
  Float3 fill, rim;  ///< unit, towards the light
  Float3 key_colour{1.72f, 1.60f, 1.44f};
  Float3 fill_colour{0.14f, 0.18f, 0.25f};
  Float3 rim_colour{0.55f, 0.60f, 0.70f};
  Float3 sky{0.34f, 0.38f, 0.44f};    ///< from above
  Float3 floor{0.24f, 0.21f, 0.19f};  ///< from below
  float key_spread = 0.16f;           ///< tangent of the angular radius
};

Lights make_lights(const View& view) {
  // Level axes of the camera; one that looks straight down lends its up axis instead.
  Vec3<double> right{view.right[0], view.right[1], 0};
  if (length_sq(right) < 1e-6) right = {1, 0, 0};
  right = normalized(right);
  const Vec3<double> away{-right[1], right[0], 0};
  const Vec3<double> z{0, 0, 1};
  // The key light rakes from the side: folds live from the change of light to shade.
  return {Frame(vec_cast<float>(normalized(right * -0.85 - away * 0.30 + z * 0.80))),
          vec_cast<float>(normalized(right * 0.80 - away * 0.60 + z * 0.25)),
          vec_cast<float>(normalized(right * 0.45 + away * 0.85 + z * 0.35))};
}

Float3 sky_light(const Lights& lights, const Float3& direction) {
  return mix(lights.floor, lights.sky, 0.5f + 0.5f * direction[2]);
}

/// What one camera ray needs to know of the point that it met.
struct Point {
  Float3 position;  ///< on the triangle
  Float3 smooth;    ///< on the curved surface that the corner normals suggest
  Float3 face;      ///< unit normal of the triangle, towards the viewer
  Float3 normal;    ///< unit shading normal, towards the viewer
  Float3 colour;
  bool cloth = false;
  bool mapped = false;  ///< `colour` stands for a number
};

class Shader {
 public:
  Shader(const std::vector<Surface>& surfaces, const RayScene& rays, const Lights& lights,
         float ground, float line_width, bool coloured_edges)
      : surfaces_(surfaces),
        rays_(rays),
        lights_(lights),
        ground_(ground),
        line_width_(line_width),
        coloured_edges_(coloured_edges) {
    for (const Surface& s : surfaces)
      if (!s.catcher)
        for (const Tri& t : s.triangles)
          for (const Index v : t.v) radius_ = std::max(radius_, length(s.position(v)));
  }

  /// Light that comes back along a camera ray.
  /// @param draw       random points
  /// @param background what the ray sees if it meets nothing
  Float3 operator()(const Float3& eye, const Float3& direction, const Draw& draw,
                    const Float3& background) const {
    const Hit hit = rays_.first(eye, direction);
    const float to_ground = direction[2] < 0 ? (ground_ - eye[2]) / direction[2] : -1.0f;
    if (to_ground > 0 && to_ground < farthest_ground_ && !(hit.any() && hit.distance < to_ground))
      return caught(eye + direction * to_ground, draw, background);
    if (!hit.any()) return background;
    if (surfaces_[hit.surface].catcher)
      return caught(eye + direction * hit.distance, draw, background);
    const Point point = point_of(hit, eye, direction);
    const Float3 light = point.mapped ? mapped(point, draw) : shaded(point, direction, draw);
    if (point.mapped && coloured_edges_) return light;
    return line_width_ > 0 && point.cloth ? light * edge_light(hit) : light;
  }

 private:
  static constexpr float lift_ = 2e-4f;  ///< start of rays above a surface, against self-shadows
  static constexpr float farthest_ground_ = 1e6f;
  static constexpr float line_light_ = 0.65f;  ///< that a line along an edge takes
  static constexpr float line_dark_ = 1 - line_light_;
  static constexpr Float3 pale_{0.62f, 0.62f, 0.60f};  ///< cloth whose edges are coloured
  static constexpr float reach_ = 0.45f;               ///< of the light from the surroundings

  Point point_of(const Hit& hit, const Float3& eye, const Float3& direction) const {
    const Surface& surface = surfaces_[hit.surface];
    const std::array<float, 3> weight{1 - hit.u - hit.v, hit.u, hit.v};
    Point p;
    p.cloth = surface.cloth;
    p.position = eye + direction * hit.distance;
    p.face = normalized(hit.face_normal);
    const bool behind = dot(p.face, direction) > 0;
    p.colour = behind ? surface.back : surface.front;
    if (!surface.values.empty()) {
      p.mapped = true;
      float value = 0;
      for (std::size_t k = 0; k < 3; ++k) value += weight[k] * surface.values[3 * hit.triangle + k];
      p.colour = mapped_light(value);
      if (coloured_edges_)
        p.colour = mix(pale_, p.colour, 1 - 0.8f * (edge_light(hit) - line_dark_) / line_light_);
    }
    if (behind) p.face = -p.face;
    p.normal = {0, 0, 0};
    Float3 offset{0, 0, 0};
    for (std::size_t k = 0; k < 3; ++k) {
      Float3 n = surface.normals[3 * hit.triangle + k];
      if (behind) n = -n;
      const Index v = surface.triangles[hit.triangle].v[k];
      const float below = dot(p.position - surface.position(v), n);
      // Shadow rays start on the curved surface (Hanika 2021), or the facets would show where the
      // light grazes.
      if (below < 0) offset += n * (-below * weight[k]);
      p.normal += n * weight[k];
    }
    p.smooth = p.position + offset;
    p.normal = normalized(p.normal);
    // A normal that turns away from the viewer is bent back to the outline.
    const float away = dot(p.normal, direction);
    if (away > -0.02f) p.normal = normalized(p.normal - direction * (away + 0.02f));
    return p;
  }

  /// Towards a point of the key light, a far disc. About unit length.
  Float3 key_direction(const Draw& draw) const {
    return lights_.key.z +
           (lights_.key.x * draw.light.x + lights_.key.y * draw.light.y) * lights_.key_spread;
  }

  /// Light from the near surroundings: sky where the way is free. Reach differs from ray to ray, so
  /// that nearness counts.
  bool open(const Float3& origin, const Float3& direction, float u, float reach) const {
    return !rays_.blocked(origin, direction, lift_ + reach * u * u);
  }

  Float3 shaded(const Point& p, const Float3& direction, const Draw& draw) const {
    const float facing = std::max(0.0f, -dot(p.normal, direction));
    const float edge = std::pow(1 - facing, 3.0f);

    const Float3 to_key = key_direction(draw);
    const float side = dot(p.normal, to_key) > 0 ? 1.0f : -1.0f;
    // Thin cloth lets a little of the light from behind through.
    const float through = p.cloth ? 0.16f : 0.0f;
    float key = std::max(0.0f, side * dot(p.normal, to_key)) * (side > 0 ? 1.0f : through);
    const Float3 start = (side > 0 ? p.smooth : p.position) + p.normal * (side * 3 * lift_);
    if (key > 0 && rays_.blocked(start, to_key, std::numeric_limits<float>::infinity())) key = 0;

    Float3 about = cosine_direction(p.normal, draw.around);
    const float below = dot(about, p.face);
    if (below < 0) about -= p.face * (2 * below);
    const bool free = open(p.smooth + p.face * lift_, about, draw.reach, reach_);
    // Light that neighbours of the same colour pass on keeps the depth of folds warm.
    const Float3 near = free ? sky_light(lights_, about) : p.colour * 0.20f;
    const float fill = free ? std::max(0.0f, dot(p.normal, lights_.fill)) : 0.0f;
    const float rim = free ? std::max(0.0f, dot(p.normal, lights_.rim) + 0.2f) * edge : 0.0f;

    Float3 light = tint(p.colour, lights_.key_colour * key + near + lights_.fill_colour * fill);
    const Float3 sheen = mix(p.colour, Float3{1, 1, 1}, 0.35f);
    light += tint(sheen, lights_.rim_colour * (rim * (p.cloth ? 0.5f : 0.25f)));
    if (p.cloth) light += sheen * (edge * (0.10f * (free ? 1.0f : 0.0f) + 0.22f * key));
    return light;
  }

  /// Colour of the map under white light: shade tells the folds, the hue is left alone.
  Float3 mapped(const Point& p, const Draw& draw) const {
    const Float3 to_key = key_direction(draw);
    float key = std::max(0.0f, dot(p.normal, to_key));
    const Float3 start = p.smooth + p.normal * (3 * lift_);
    if (key > 0 && rays_.blocked(start, to_key, std::numeric_limits<float>::infinity())) key = 0;
    Float3 about = cosine_direction(p.normal, draw.around);
    const float below = dot(about, p.face);
    if (below < 0) about -= p.face * (2 * below);
    const bool free = open(p.smooth + p.face * lift_, about, draw.reach, reach_);
    return p.colour * (0.34f + (free ? 0.36f : 0.0f) + 0.34f * key);
  }

  /// How much light a line along the triangle's edges leaves; lines fade where triangles are so
  /// small that they would be nothing but lines.
  float edge_light(const Hit& hit) const {
    const Surface& surface = surfaces_[hit.surface];
    const Index* v = surface.triangles[hit.triangle].v;
    const std::array<float, 3> weight{1 - hit.u - hit.v, hit.u, hit.v};
    const float width = line_width_ * hit.distance;
    const float doubled_area = length(hit.face_normal);
    float nearest = std::numeric_limits<float>::infinity(), size = nearest;
    for (std::size_t k = 0; k < 3; ++k) {
      const float edge =
          length(surface.position(v[(k + 2) % 3]) - surface.position(v[(k + 1) % 3]));
      if (!(edge > 0)) return 1;
      nearest = std::min(nearest, weight[k] * doubled_area / edge);
      size = std::min(size, doubled_area / edge);
    }
    if (nearest > 0.5f * width) return 1;
    return 1 - line_light_ * std::clamp((size / width - 2.5f) / 6, 0.0f, 1.0f);
  }

  /// Background behind a shadow catcher: dimmed where the light does not arrive.
  Float3 caught(const Float3& point, const Draw& draw, const Float3& background) const {
    const Float3 up{0, 0, 1};
    const Float3 start = point + up * lift_;
    const Float3 to_key = key_direction(draw);
    // Most of the ground is so far away from everything that no ray need be sent.
    const bool may_shade =
        length_sq(start - to_key * dot(start, to_key)) < 1.1f * radius_ * radius_;
    const bool lit =
        !may_shade || !rays_.blocked(start, to_key, std::numeric_limits<float>::infinity());
    const float near = radius_ + 1.5f * reach_;
    const bool free = length_sq(start) > near * near ||
                      open(start, cosine_direction(up, draw.around), draw.reach, 1.5f * reach_);
    const Float3 shadow{0.46f, 0.48f, 0.54f};
    return tint(background, mix(shadow, {1, 1, 1}, lit ? 1.0f : 0.0f)) * (free ? 1.0f : 0.36f);
  }

  const std::vector<Surface>& surfaces_;
  const RayScene& rays_;
  Lights lights_;
  float ground_;
  float line_width_;  ///< at distance 1; 0: no lines
  bool coloured_edges_;
  float radius_ = 0;  ///< of the ball about the origin that holds all but the floors
};

// ---------------------------------------------------------------- picture

/// Light backdrop: bright behind the subject, darker towards the corners and the bottom.
/// @param x, y  place in the picture, -1..1 from the left and from the top
Float3 backdrop(float x, float y) {
  const Float3 high{1.02f, 1.05f, 1.08f}, low{0.72f, 0.71f, 0.695f};
  const float r_sq = 0.5f * (x * x + (y + 0.2f) * (y + 0.2f));
  return mix(high, low, std::clamp(0.5f + 0.5f * y, 0.0f, 1.0f)) * (1 - 0.16f * r_sq);
}

/// @param dither  0..1, against steps in slow gradients
std::uint8_t tone(float x, float dither) {
  const float value = 255 * std::pow(std::clamp(filmic(x), 0.0f, 1.0f), 1 / 2.2f);
  return static_cast<std::uint8_t>(std::min(value + dither, 255.0f));
}

/// Everything that a pixel depends on.
struct Scenery {
  const Shader& shader;
  const Samples& samples;
  int width, height;
  Float3 eye, right, up, forward;  ///< right and up span half the picture at distance 1
};

void render_pixel(const Scenery& scenery, int x, int y, std::uint8_t* rgb) {
  const Samples& samples = scenery.samples;
  const Samples::Pixel fixed =
      Samples::pixel(static_cast<std::uint64_t>(y) * static_cast<std::uint64_t>(scenery.width) +
                     static_cast<std::uint64_t>(x));
  const float width = static_cast<float>(scenery.width),
              height = static_cast<float>(scenery.height);
  Float3 sum{0, 0, 0};
  for (unsigned i = 0; i < samples.count(); ++i) {
    // Places thin out away from the middle of the pixel: smoother edges than an even spread.
    const Point2 place = samples.disc(fixed, 0, i);
    const float spread = 0.55f + 0.45f * (place.x * place.x + place.y * place.y);
    const float sx = 2 * (static_cast<float>(x) + 0.5f + spread * place.x) / width - 1;
    const float sy = 2 * (static_cast<float>(y) + 0.5f + spread * place.y) / height - 1;
    const Float3 direction = normalized(scenery.forward + scenery.right * sx - scenery.up * sy);
    const Draw draw{samples.disc(fixed, 1, i), samples.disc(fixed, 2, i), samples.line(fixed, i)};
    sum += scenery.shader(scenery.eye, direction, draw, backdrop(sx, sy));
  }
  const float share = 1 / static_cast<float>(samples.count());
  for (int k = 0; k < 3; ++k) rgb[k] = tone(sum[k] * share, fixed.phase);
}

/// Renders tiles until none is left. A pixel depends on its place alone, so the threads share
/// nothing but the number of the next tile.
void render_tiles(const Scenery& scenery, std::atomic<int>& next, std::uint8_t* rgb) {
  constexpr int size = 16;
  const int columns = (scenery.width + size - 1) / size;
  const int rows = (scenery.height + size - 1) / size;
  for (int tile = next++; tile < columns * rows; tile = next++) {
    const int x0 = tile % columns * size, y0 = tile / columns * size;
    for (int y = y0; y < std::min(y0 + size, scenery.height); ++y)
      for (int x = x0; x < std::min(x0 + size, scenery.width); ++x)
        render_pixel(scenery, x, y, rgb + 3 * (std::ptrdiff_t{y} * scenery.width + x));
  }
}

Image render_image(const Scenery& scenery, int threads) {
  Image image{scenery.width, scenery.height, {}};
  image.rgb.resize(std::size_t{3} * static_cast<std::size_t>(image.width) *
                   static_cast<std::size_t>(image.height));
  std::atomic<int> next{0};
  const unsigned count =
      threads > 0 ? static_cast<unsigned>(threads) : std::thread::hardware_concurrency();
  {
    std::vector<std::jthread> others;
    for (unsigned i = 1; i < count; ++i)
      others.emplace_back([&] { render_tiles(scenery, next, image.rgb.data()); });
    render_tiles(scenery, next, image.rgb.data());
  }
  return image;
}

/// Height of the shadow catcher in the world, or minus infinity for none.
double ground_height(const Contents& contents, const PictureOptions& options) {
  if (!options.ground ||
      std::any_of(contents.obstacles.begin(), contents.obstacles.end(), named_like_floor))
    return -std::numeric_limits<double>::infinity();
  return options.ground_height.value_or(contents.lowest);
}

}  // namespace

Image render_picture(const std::vector<NamedMesh>& cloths, const std::vector<NamedMesh>& obstacles,
                     const PictureOptions& options, const PictureValues* values) {
  check_options(options);
  const Contents contents = make_contents(cloths, obstacles, subject_of(options));
  const PictureOptions framed = framed_options(contents, options);
  const View view(framed.eye, framed.look_at, framed.up);
  // A micrometre is small for cloth; what is smaller still would leave the range of float.
  const Placement place{contents.framed_box.center(),
                        2 / std::max(contents.framed_box.diagonal(), 1e-6)};
  if (!Placement::holds(place(framed.eye)))
    throw SceneError("", "picture.eye", "too far away", "within 1e8 sizes of the cloths");
  std::vector<Surface> surfaces = make_surfaces(contents, place, values);
  // A hair below the lowest point, so that cloth on the ground stands out from it.
  const double ground = (ground_height(contents, framed) - place.center[2]) * place.scale - 1e-3;
  const double half = half_height(framed);
  const double line = 1.2 * 2 * half / framed.height;  // 1.2 pixels
  const bool coloured = framed.coloured_edges && values != nullptr;
  if (!framed.wires.empty())
    surfaces.push_back(wire_surface(framed.wires, place, framed.eye, 1.5 * line));
  const RayScene rays(surfaces);
  const Shader shader(surfaces, rays, make_lights(view), static_cast<float>(ground),
                      static_cast<float>(framed.edges || coloured ? line : 0), coloured);
  const Samples samples(static_cast<unsigned>(framed.samples));
  const Scenery scenery{shader,
                        samples,
                        framed.width,
                        framed.height,
                        vec_cast<float>(place(framed.eye)),
                        vec_cast<float>(view.right * (half * framed.width / framed.height)),
                        vec_cast<float>(view.up * half),
                        vec_cast<float>(view.forward)};
  return render_image(scenery, framed.threads);
}

}  // namespace weft::io
