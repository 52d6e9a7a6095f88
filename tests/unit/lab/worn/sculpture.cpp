#include "tests/unit/lab/worn/sculpture.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace weft::lab::test {
namespace {

constexpr double degree = std::numbers::pi / 180;

// Distance from a cone with round ends, from the origin along the unit axis `e` to `l`. In the
// plane of the axis and q, it is the distance from the segment that touches both end circles.
double cone_distance(const Point& q, const Point& e, double l, double ra, double rb,
                     Point* gradient) {
  const double y = dot(q, e);
  const double x = std::sqrt(std::max(0.0, dot(q, q) - y * y));
  const double s = (ra - rb) / l, c = std::sqrt(std::max(0.0, 1 - s * s));
  const double t = y * c - x * s;
  const double along_end = t < 0 ? y : y - l;
  if (t < 0 || t > l * c) {
    const double d = std::sqrt(x * x + along_end * along_end);
    if (gradient) *gradient = d > 1e-12 ? (1 / d) * (q + (along_end - y) * e) : e;
    return d - (t < 0 ? ra : rb);
  }
  if (gradient) *gradient = x > 1e-12 ? (c / x) * q + (s - c * y / x) * e : e;
  return x * c + y * s - ra;
}

double ellipsoid_distance(const Point& q, const Point& r, Point* gradient) {
  const Point u{q[0] / r[0], q[1] / r[1], q[2] / r[2]};
  const Point u1{u[0] / r[0], u[1] / r[1], u[2] / r[2]};
  const double k0 = std::sqrt(dot(u, u)), k1 = std::sqrt(dot(u1, u1));
  if (k1 < 1e-9) {
    if (gradient) *gradient = {0, 0, 1};
    return -std::min({r[0], r[1], r[2]});
  }
  const double d = k0 * (k0 - 1) / k1;
  if (gradient) {
    const Point u2{u1[0] / (r[0] * r[0]), u1[1] / (r[1] * r[1]), u1[2] / (r[2] * r[2])};
    *gradient = ((2 * k0 - 1) / (k0 * k1)) * u1 - (d / (k1 * k1)) * u2;
  }
  return d;
}

constexpr std::array<int, bone_count> parents{-1, 0, 1, 2, 3,  2,  2,  5, 6,
                                              7,  8, 0, 0, 11, 12, 13, 14};

bool adjacent(std::size_t a, std::size_t b) {
  const auto thigh = [](std::size_t i) { return i == 11 || i == 12; };
  return a == b || parents[a] == static_cast<int>(b) || parents[b] == static_cast<int>(a) ||
         (thigh(a) && thigh(b));
}

}  // namespace

double smooth_step(double from, double to, double x) {
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

Point unit(Point a) {
  return (1 / length(a)) * a;
}

Point turned(Point a, Point axis, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return c * a + s * cross(axis, a) + ((1 - c) * dot(axis, a)) * axis;
}

Frame Frame::rotated(Point axis, double angle) const {
  return {o, turned(x, axis, angle), turned(y, axis, angle), turned(z, axis, angle)};
}

Sculpture::Sculpture(const Proportions& proportions, const Pose& pose)
    : height_(proportions.height) {
  pose_bones(proportions, pose);
  const double h = height_, g = proportions.girth, m = proportions.limbs;
  const auto ellipsoid = [&](Bone bone, unsigned part, double blend, Point centre, Point half) {
    place({bone, part, false, blend * h, h * centre, h * half});
  };
  const auto cone = [&](Bone bone, unsigned part, double blend, Point a, Point b, double ra,
                        double rb) {
    place({bone, part, true, blend * h, h * a, h * b, h * ra, h * rb});
  };
  const auto side_bone = [](Bone left, int side) {
    return static_cast<Bone>(static_cast<int>(left) + side);
  };
  const double t = trunk_length() / h;
  ellipsoid(Bone::pelvis, trunk, 0.02, {0, 0, 0.03 * t}, {0.088 * g, 0.062 * g, 0.075});
  ellipsoid(Bone::waist, trunk, 0.05, {0, 0, 0.08 * t}, {0.074 * g, 0.054 * g, 0.26 * t});
  ellipsoid(Bone::chest, trunk, 0.05, {0, 0.004, 0.2 * t}, {0.086 * g, 0.062 * g, 0.31 * t});
  if (proportions.belly > 0) {
    const double b = proportions.belly;
    ellipsoid(Bone::waist, trunk, 0.05, {0, -0.035 * g, -0.01},
              {0.066 * g, (0.02 + 0.035 * b) * g, 0.075});
  }
  const double w = 0.105 * proportions.shoulders;
  for (const double e : {1.0, -1.0})
    cone(Bone::chest, trunk, 0.04, {0, 0.008, 0.42 * t}, {e * 0.8 * w, 0.006, 0.37 * t}, 0.036,
         0.033);
  cone(Bone::chest, trunk, 0.03, {0, 0.014, 0.47 * t}, {0, 0.006, 0.56 * t}, 0.042, 0.034);
  cone(Bone::neck, trunk, 0.02, {0, 0.006, -0.02}, {0, 0, 0.045}, 0.033, 0.03);
  const double s = proportions.head;
  ellipsoid(Bone::head, test::head, 0.02, {0, -0.004, 0.07 * s}, {0.046 * s, 0.057 * s, 0.062 * s});
  ellipsoid(Bone::head, test::head, 0.02, {0, -0.025 * s, 0.03 * s},
            {0.03 * s, 0.032 * s, 0.032 * s});
  ellipsoid(Bone::head, test::head, 0.012, {0, -0.058 * s, 0.058 * s},
            {0.01 * s, 0.014 * s, 0.014 * s});
  for (int side = 0; side < 2; ++side) {
    const double e = sign_of(side);
    const auto i = static_cast<std::size_t>(side);
    if (proportions.breast[i] > 0) {
      const double b = 0.7 + 0.3 * proportions.breast[i];
      ellipsoid(Bone::chest, trunk, 0.02, {e * 0.042 * g, -0.048 * g, 0.1 * t},
                {0.036 * b, 0.03 * proportions.breast[i] + 0.006, 0.036 * b});
    }
    const double c = proportions.buttock[i];
    ellipsoid(Bone::pelvis, trunk, 0.03, {e * 0.044, 0.026 * g, -0.02},
              {0.046 * c, 0.042 * c, 0.052 * c});
    const unsigned a = arm(side), l = leg(side);
    const double ua = length(bone(Bone::forearm_l, side).o - shoulder(side)) / h;
    const double fa = length(wrist(side) - bone(Bone::forearm_l, side).o) / h;
    ellipsoid(side_bone(Bone::upper_arm_l, side), a, 0.03, {e * 0.004, 0, -0.02},
              {0.033 * m, 0.034 * m, 0.05});
    cone(side_bone(Bone::upper_arm_l, side), a, 0.03, {0, 0, 0}, {0, 0, -ua}, 0.03 * m, 0.024 * m);
    ellipsoid(side_bone(Bone::upper_arm_l, side), a, 0.02, {0, -0.008, -0.55 * ua},
              {0.024 * m, 0.026 * m, 0.05});
    cone(side_bone(Bone::forearm_l, side), a, 0.015, {0, 0, 0}, {0, 0, -fa},
         std::max(0.024, 0.025 * m), std::max(0.0215, 0.02 * m));
    ellipsoid(side_bone(Bone::hand_l, side), a, 0.012, {0, -0.004, -0.042}, {0.022, 0.028, 0.05});
    const double th = length(bone(Bone::shin_l, side).o - hip(side)) / h;
    const double sh = length(ankle(side) - bone(Bone::shin_l, side).o) / h;
    cone(side_bone(Bone::thigh_l, side), l, 0.03, {0, 0, 0}, {0, 0, -th}, 0.05 * m, 0.033 * m);
    ellipsoid(side_bone(Bone::thigh_l, side), l, 0.03, {e * 0.006, -0.01, -0.35 * th},
              {0.044 * m, 0.048 * m, 0.09});
    cone(side_bone(Bone::shin_l, side), l, 0.015, {0, 0, 0}, {0, 0, -sh}, 0.032 * m,
         std::max(0.022, 0.021 * m));
    ellipsoid(side_bone(Bone::shin_l, side), l, 0.015, {0, 0.014, -0.3 * sh},
              {0.027 * m, 0.028 * m, 0.06});
    ellipsoid(side_bone(Bone::foot_l, side), l, 0.012, {0, -0.035, -0.024}, {0.026, 0.068, 0.021});
  }
}

void Sculpture::pose_bones(const Proportions& proportions, const Pose& pose) {
  const double h = height_;
  const auto at_bone = [&](Bone b) -> Frame& { return frames_[static_cast<std::size_t>(b)]; };
  const auto side_bone = [&](Bone left, int side) -> Frame& {
    return frames_[static_cast<std::size_t>(left) + static_cast<std::size_t>(side)];
  };
  const double t = (1 - 0.132 * proportions.head - 0.058 - proportions.hip_height) * h;
  Frame pelvis{{0, 0, proportions.hip_height * h}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  at_bone(Bone::pelvis) = pelvis;
  const auto next = [&](Bone parent, Point offset) {
    Frame f = at_bone(parent);
    f.o = f.world(offset);
    return f;
  };
  // Half of each angle at the waist, half at the chest.
  const auto bent = [&](Frame f) {
    f = f.rotated(f.z, 0.5 * degree * pose.trunk_turn);
    return f.rotated(f.x, 0.5 * degree * pose.trunk_lean);
  };
  at_bone(Bone::waist) = bent(next(Bone::pelvis, {0, 0, 0.27 * t}));
  at_bone(Bone::chest) = bent(next(Bone::waist, {0, 0, 0.28 * t}));
  at_bone(Bone::neck) = next(Bone::chest, {0, 0, 0.53 * t});
  at_bone(Bone::head) = next(Bone::neck, {0, 0, 0.045 * h});
  const double arm_length = 0.325 * h, leg_length = (proportions.hip_height - 0.045) * h;
  for (int side = 0; side < 2; ++side) {
    const double e = sign_of(side);
    const auto i = static_cast<std::size_t>(side);
    Frame a = next(Bone::chest, {e * 0.105 * proportions.shoulders * h, 0.006 * h, 0.4 * t});
    a = a.rotated(a.y, -e * degree * pose.arm_raise[i]);
    a = a.rotated(at_bone(Bone::chest).x, -degree * pose.arm_forward[i]);
    side_bone(Bone::upper_arm_l, side) = a;
    a.o = a.world({0, 0, -0.53 * arm_length});
    a = a.rotated(a.x, -degree * pose.elbow[i]);
    side_bone(Bone::forearm_l, side) = a;
    a.o = a.world({0, 0, -0.47 * arm_length});
    side_bone(Bone::hand_l, side) = a;
    Frame l = next(Bone::pelvis, {e * 0.054 * h, 0, 0});
    l = l.rotated(l.y, -e * degree * pose.leg_spread[i]);
    l = l.rotated(at_bone(Bone::pelvis).x, -degree * pose.leg_forward[i]);
    side_bone(Bone::thigh_l, side) = l;
    l.o = l.world({0, 0, -0.5 * leg_length});
    l = l.rotated(l.x, degree * pose.knee[i]);
    side_bone(Bone::shin_l, side) = l;
    l.o = l.world({0, 0, -0.5 * leg_length});
    // Soles stay level.
    l = l.rotated(l.x, degree * (pose.leg_forward[i] - pose.knee[i]));
    side_bone(Bone::foot_l, side) = l;
  }
  const double low = std::min(ankle(0)[2], ankle(1)[2]) - 0.045 * h;
  for (Frame& f : frames_) f.o[2] -= low;
}

void Sculpture::place(Blob blob) {
  const Frame& f = bone(blob.bone);
  if (blob.round_cone) {
    blob.axis = unit(blob.b - blob.a);
    blob.length = length(blob.b - blob.a);
    blob.end = f.world(blob.a);
    blob.world_axis = f.vector(blob.axis);
    blob.centre = f.world(0.5 * (blob.a + blob.b));
    blob.radius = 0.5 * length(blob.b - blob.a) + std::max(blob.ra, blob.rb);
  } else {
    blob.centre = f.world(blob.a);
    blob.radius = std::max({blob.b[0], blob.b[1], blob.b[2]});
  }
  blobs_.push_back(blob);
}

void Sculpture::add_cone(Bone bone, double from, double to, double radius_from, double radius_to,
                         double flat) {
  Blob blob{bone, extra, true, 0.03 * height_, {0, 0, from}, {0, 0, to}, radius_from, radius_to};
  blob.flat = flat;
  place(blob);
}

double Sculpture::blob_distance(const Blob& blob, Point p, Point* gradient) const {
  if (blob.round_cone && blob.flat == 1)
    return cone_distance(p - blob.end, blob.world_axis, blob.length, blob.ra, blob.rb, gradient);
  const Frame& f = bone(blob.bone);
  Point q = f.local(p) - blob.a;
  double d;
  if (!blob.round_cone) {
    d = ellipsoid_distance(q, blob.b, gradient);
  } else {
    q[1] /= blob.flat;
    d = blob.flat * cone_distance(q, blob.axis, blob.length, blob.ra, blob.rb, gradient);
    if (gradient)
      *gradient = {blob.flat * (*gradient)[0], (*gradient)[1], blob.flat * (*gradient)[2]};
  }
  if (gradient) *gradient = f.vector(*gradient);
  return d;
}

double Sculpture::distance(Point p, unsigned parts, Point* gradient) const {
  double best = 1e3;
  for (const Blob& blob : blobs_) {
    if (!(blob.part & parts)) continue;
    if (is_beyond(blob, p, best + blob.blend)) continue;
    Point g{};
    const double d = blob_distance(blob, p, gradient ? &g : nullptr);
    // Inigo Quilez's blend, at most blend / 4 below the lesser distance.
    const double h = std::max(blob.blend - std::abs(best - d), 0.0) / blob.blend;
    if (gradient) {
      const double share = d < best ? 1 - 0.5 * h : 0.5 * h;
      *gradient = share > 0.999999 ? g : (1 - share) * *gradient + share * g;
    }
    best = std::min(best, d) - 0.25 * h * h * blob.blend;
  }
  return best;
}

Point Sculpture::gradient(Point p, unsigned parts) const {
  Point g{0, 0, 1};
  distance(p, parts, &g);
  return g;
}

Part Sculpture::nearest_part(Point p, unsigned parts) const {
  double best = 1e3;
  unsigned nearest = trunk;
  for (const Blob& blob : blobs_) {
    if (!(blob.part & parts) || is_beyond(blob, p, best)) continue;
    const double d = blob_distance(blob, p, nullptr);
    if (d < best) {
      best = d;
      nearest = blob.part;
    }
  }
  return static_cast<Part>(nearest);
}

bool Sculpture::is_beyond(const Blob& blob, const Point& p, double reach) {
  if (blob.flat != 1) return false;  // its sphere is not around it
  const Point q = p - blob.centre;
  const double r = reach + blob.radius;
  return r > 0 && q[0] * q[0] + q[1] * q[1] + q[2] * q[2] > r * r;
}

std::array<Point, 3> Sculpture::axis(Part limb) const {
  const int side = limb == arm_l || limb == leg_l ? 0 : 1;
  if (limb == arm_l || limb == arm_r)
    return {shoulder(side), bone(Bone::forearm_l, side).o, wrist(side)};
  return {hip(side), bone(Bone::shin_l, side).o, ankle(side)};
}

double Sculpture::along(Part limb, Point p) const {
  const auto [a, b, c] = axis(limb);
  const double l1 = length(b - a), l2 = length(c - b);
  const double s1 = std::min(dot(p - a, b - a) / l1, l1);
  const double s2 = std::max(dot(p - b, c - b) / l2, 0.0);
  const double d1 = length(p - a - (s1 / l1) * (b - a));
  const double d2 = length(p - b - (s2 / l2) * (c - b));
  return d1 <= d2 ? s1 : l1 + s2;
}

Point Sculpture::axis_point(Part limb, Point p) const {
  const auto [a, b, c] = axis(limb);
  const double l1 = length(b - a);
  const double s = along(limb, p);
  return s <= l1 ? a + (s / l1) * (b - a) : b + (s - l1) * unit(c - b);
}

Point Sculpture::axis_direction(Part limb, Point p) const {
  const auto [a, b, c] = axis(limb);
  return along(limb, p) <= length(b - a) ? unit(b - a) : unit(c - b);
}

Sculpture::Weights Sculpture::weights(Point p) const {
  Weights d;
  d.fill(1e3);
  // Bones that are farther than this from the nearest one hold nothing.
  const double far = 0.15 * height_;
  double best = 1e3;
  for (const Blob& blob : blobs_) {
    if (blob.part == extra || is_beyond(blob, p, best + far)) continue;
    double& at_bone = d[static_cast<std::size_t>(blob.bone)];
    at_bone = std::min(at_bone, blob_distance(blob, p, nullptr));
    best = std::min(best, at_bone);
  }
  const std::size_t nearest =
      static_cast<std::size_t>(std::min_element(d.begin(), d.end()) - d.begin());
  Weights w{};
  double sum = 0;
  for (std::size_t b = 0; b < bone_count; ++b)
    if (adjacent(b, nearest)) sum += w[b] = std::exp((d[nearest] - d[b]) / (0.018 * height_));
  for (double& x : w) x /= sum;
  return w;
}

Point Sculpture::carried(Point p, const Weights& weights, const Sculpture& to) const {
  Point moved{0, 0, 0};
  for (std::size_t b = 0; b < bone_count; ++b)
    if (weights[b] > 0) moved += weights[b] * to.frames_[b].world(frames_[b].local(p));
  return moved;
}

double Sculpture::to_the_back(Point p) const {
  const Weights w = weights(p);
  double y = 0;
  for (std::size_t b = 0; b < bone_count; ++b)
    if (w[b] > 0) y += w[b] * frames_[b].local(p)[1];
  return y;
}

void Sculpture::bounds(unsigned parts, Point& low, Point& high) const {
  low = {1e3, 1e3, 1e3};
  high = -low;
  for (const Blob& blob : blobs_)
    if (blob.part & parts)
      for (int d = 0; d < 3; ++d) {
        low[d] = std::min(low[d], blob.centre[d] - blob.radius);
        high[d] = std::max(high[d], blob.centre[d] + blob.radius);
      }
}

}  // namespace weft::lab::test
