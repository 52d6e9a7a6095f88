#include "host/io/animation/capture_body.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string_view>
#include <vector>

#include "host/base/lower_case.hpp"
#include "host/geometry/aabb.hpp"
#include "weft/error.hpp"
#include "weft/shapes.hpp"

namespace weft::io {
namespace {

/// Words in the names of joints, and the radius of the bone below as a share of the body's height.
/// The first that fits counts, so "forearm" stands before "arm". Plain estimates for a grown body,
/// to be replaced by `radius` where it matters.
struct Girth {
  std::string_view word;
  double share;
};
constexpr std::array<Girth, 37> girths{{
    {"thumb", 0.006},    {"index", 0.006},   {"middle", 0.006},   {"ring", 0.006},
    {"pinky", 0.005},    {"finger", 0.006},  {"toe", 0.016},      {"foot", 0.022},
    {"ankle", 0.022},    {"forearm", 0.024}, {"lowerarm", 0.024}, {"lowarm", 0.024},
    {"elbow", 0.024},    {"hand", 0.018},    {"wrist", 0.018},    {"upleg", 0.045},
    {"upperleg", 0.045}, {"thigh", 0.045},   {"lowerleg", 0.031}, {"lowleg", 0.031},
    {"shin", 0.031},     {"calf", 0.031},    {"knee", 0.031},     {"leg", 0.031},
    {"collar", 0.035},   {"clav", 0.035},    {"upperarm", 0.03},  {"shoulder", 0.032},
    {"arm", 0.03},       {"neck", 0.032},    {"head", 0.05},      {"hips", 0.07},
    {"pelvis", 0.07},    {"hip", 0.045},     {"spine", 0.07},     {"chest", 0.075},
    {"torso", 0.075},
}};

/// Where the joints are if no channel says else.
std::vector<Vec3<double>> joints_at_rest(const Capture& capture) {
  std::vector<Vec3<double>> at;
  for (const CaptureJoint& joint : capture.joints)
    at.push_back(joint.parent < 0 ? joint.offset
                                  : at[static_cast<std::size_t>(joint.parent)] + joint.offset);
  return at;
}

/// Sides of the box around the skeleton at rest.
Vec3<double> size_at_rest(const Capture& capture) {
  return aabb_of(joints_at_rest(capture)).size();
}

Vec3<double> translation_in(const Capture& capture, const CaptureJoint& joint, std::size_t frame) {
  Vec3<double> at = joint.offset;
  for (std::size_t c = 0; c < joint.channels.size(); ++c)
    if (!joint.channels[c].rotation)
      at[joint.channels[c].axis] = capture.value(frame, joint.first_channel + c);
  return at;
}

Quaternion rotation_in(const Capture& capture, const CaptureJoint& joint, std::size_t frame) {
  Quaternion turn;
  for (std::size_t c = 0; c < joint.channels.size(); ++c) {
    if (!joint.channels[c].rotation) continue;
    Vec3<double> axis{0, 0, 0};
    axis[joint.channels[c].axis] = 1;
    turn = turn * rotation_about(axis, capture.value(frame, joint.first_channel + c) *
                                           (std::numbers::pi / 180));
  }
  return normalized(turn);
}

SkeletonNode node_of(const Capture& capture, const CaptureJoint& joint, std::size_t first,
                     std::size_t last) {
  SkeletonNode node;
  node.name = joint.name;
  node.parent = joint.parent;
  node.local.translate = joint.offset;
  node.animated = !joint.channels.empty();
  if (!node.animated) return node;
  const auto moves = [&](bool rotation) {
    return std::any_of(joint.channels.begin(), joint.channels.end(),
                       [&](const CaptureChannel& c) { return c.rotation == rotation; });
  };
  const bool turns = moves(true);
  const bool shifts = moves(false);
  for (std::size_t f = first; f <= last; ++f) {
    const double time = static_cast<double>(f - first) * capture.frame_time;
    if (turns || f == first) node.rotate.emplace_back(time, rotation_in(capture, joint, f));
    if (shifts || f == first) node.translate.emplace_back(time, translation_in(capture, joint, f));
  }
  node.scale.emplace_back(0, Vec3<double>{1, 1, 1});
  return node;
}

/// A capsule in the frame of a joint. [units of the file]
struct BoneShape {
  Index node;
  Vec3<double> start, end;  ///< centres of the caps
  double radius;
};

std::vector<BoneShape> shapes_of(const Capture& capture, const CaptureBody& body) {
  const Vec3<double> box = size_at_rest(capture);
  const double size = std::max({box[0], box[1], box[2]});
  std::vector<BoneShape> shapes;
  for (const CaptureJoint& joint : capture.joints) {
    if (joint.parent < 0) continue;
    // A joint with positions of its own may have any offset; the first frame says how far it is.
    const Vec3<double> end = translation_in(capture, joint, body.first_frame);
    const double bone = length(end);
    if (!(bone > size / 400)) continue;
    const std::string& name = capture.joints[static_cast<std::size_t>(joint.parent)].name;
    const auto given = body.radii.find(name);
    const double radius = given != body.radii.end() ? given->second
                          : body.radius
                              ? *body.radius
                              : default_radius(name, bone * body.scale, size * body.scale);
    BoneShape shape{joint.parent, {0, 0, 0}, end, radius / body.scale};
    if (joint.end_site) shape.end = end * std::max(1 - shape.radius / bone, 0.1);
    shapes.push_back(shape);
  }
  return shapes;
}

/// Rings of the caps of a capsule whose edges are near `edge`.
Index rings_for(double radius, double edge) {
  return static_cast<Index>(
      std::clamp(std::round(std::numbers::pi / 2 * radius / edge), 2.0, 1000.0));
}

/// Edge [units of the file] with which the body stays below its limit.
double affordable_edge(const std::vector<BoneShape>& shapes, double edge, const std::string& file) {
  double coarsest = 0;
  double thinnest = shapes.front().radius;
  for (const BoneShape& s : shapes) {
    coarsest += capsule_triangles(s.radius, length(s.end - s.start), 2);
    thinnest = std::min(thinnest, s.radius);
  }
  if (!(coarsest <= 100 * max_body_triangles))
    throw SceneError(file, "radius", "far below the length of the bones", "thicker bones");
  edge = std::max(edge, thinnest / 1000);
  while (true) {
    double sum = 0;
    for (const BoneShape& s : shapes)
      sum += capsule_triangles(s.radius, length(s.end - s.start), rings_for(s.radius, edge));
    if (sum <= std::max(max_body_triangles, coarsest)) return edge;
    edge *= 1.05;
  }
}

void add_capsule(const BoneShape& shape, double edge, SkinnedSurface& surface) {
  const Vec3<double> along = shape.end - shape.start;
  const double tube = length(along);
  const Mesh mesh = make_capsule(shape.radius, tube, rings_for(shape.radius, edge));
  // A right-handed frame whose third axis runs along the bone.
  const Vec3<double> z = along * (1 / tube);
  const Vec3<double> other = std::fabs(z[0]) < 0.9 ? Vec3<double>{1, 0, 0} : Vec3<double>{0, 1, 0};
  Vec3<double> x = other - z * dot(other, z);
  x *= 1 / length(x);
  const Vec3<double> y = cross(z, x);
  const Vec3<double> middle = (shape.start + shape.end) * 0.5;
  Skin& skin = surface.skin;
  const auto first = static_cast<Index>(skin.rest.size());
  for (const Vec3<double>& p : mesh.positions) {
    skin.rest.push_back(middle + x * p[0] + y * p[1] + z * p[2]);
    skin.influences.push_back({shape.node, 1});
    skin.first_influence.push_back(static_cast<Offset>(skin.influences.size()));
  }
  for (const Tri& t : mesh.triangles)
    surface.triangles.push_back({{first + t.v[0], first + t.v[1], first + t.v[2]}});
}

}  // namespace

double capture_height(const Capture& capture, bool y_up) {
  return size_at_rest(capture)[y_up ? 1 : 2];
}

double default_radius(const std::string& name, double length, double size) {
  const std::string word = lower_case(name);
  for (const Girth& girth : girths)
    if (word.find(girth.word) != std::string::npos) return girth.share * size;
  return std::clamp(0.2 * length, 0.006 * size, 0.06 * size);
}

SkinnedSurface make_capture_body(const Capture& capture, const CaptureBody& body,
                                 const std::string& file) {
  const std::vector<BoneShape> shapes = shapes_of(capture, body);
  if (shapes.empty())
    throw SceneError(file, "OFFSET", "no bone", "at least one bone with a length");
  SkinnedSurface surface;
  Skin& skin = surface.skin;
  for (const CaptureJoint& joint : capture.joints)
    skin.nodes.push_back(node_of(capture, joint, body.first_frame, body.last_frame));
  for (std::size_t n = 0; n < skin.nodes.size(); ++n)
    skin.bones.push_back({static_cast<Index>(n), {}});
  skin.first_influence.push_back(0);
  const double edge = affordable_edge(shapes, body.edge / body.scale, file);
  for (const BoneShape& shape : shapes) add_capsule(shape, edge, surface);
  skin.to_world = axes_to_world(body.y_up, body.scale);
  skin.duration = static_cast<double>(body.last_frame - body.first_frame) * capture.frame_time;
  return surface;
}

}  // namespace weft::io
