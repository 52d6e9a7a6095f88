#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/base/random.hpp"
#include "weft/scene.hpp"

namespace weft::lab::test {

using Point = Vec3<double>;

/// Draws numbers, the same everywhere for one seed.
struct Draw {
  std::uint64_t state;
  explicit Draw(std::uint64_t seed) : state(seed * 0x9e3779b97f4a7c15u + 17) {}
  /// @return in [low, high)
  double between(double low, double high) {
    return low + (high - low) * 0.5 * (next_random(state) + 1);
  }
};

/// @return 0 below `from`, 1 above `to`, smooth between
double smooth_step(double from, double to, double x);

/// @return `a` in its own direction with length 1
/// @pre `a` is not zero
Point unit(Point a);

/// @param axis unit
/// @param angle [rad]
/// @return `a` turned about `axis`
Point turned(Point a, Point axis, double angle);

/// Position and axes of a bone. For a person who stands, x points to the person's left, y to the
/// back, z up; along a limb, z points towards the trunk.
struct Frame {
  Point o, x, y, z;
  Point local(Point p) const { return {dot(p - o, x), dot(p - o, y), dot(p - o, z)}; }
  Point vector(Point q) const { return q[0] * x + q[1] * y + q[2] * z; }
  Point world(Point q) const { return o + vector(q); }
  /// The same place, axes turned about one of the world's directions.
  Frame rotated(Point axis, double angle) const;
};

/// What is large and small on a body, as factors of an average one.
struct Proportions {
  double height = 1.72;  ///< [m] standing, arms down
  double girth = 1;      ///< of the trunk
  double limbs = 1;      ///< thickness of arms and legs
  double shoulders = 1;  ///< width
  double head = 1;
  double hip_height = 0.51;                 ///< height of the hip joints / height
  double belly = 0;                         ///< 0 none, 1 large
  std::array<double, 2> breast{0.6, 0.6};   ///< left, right
  std::array<double, 2> buttock{1.0, 1.0};  ///< left, right
};

/// Angles of joints [degrees]; of pairs, the left one first.
struct Pose {
  std::array<double, 2> arm_raise{40, 40};  ///< 0 hangs, 90 is a T, 170 overhead
  std::array<double, 2> arm_forward{0, 0};
  std::array<double, 2> elbow{5, 5};
  std::array<double, 2> leg_spread{7, 7};
  std::array<double, 2> leg_forward{0, 0};
  std::array<double, 2> knee{0, 0};
  double trunk_turn = 0;  ///< of the chest against the pelvis, to the left
  double trunk_lean = 0;  ///< to the front
};

enum class Bone {
  pelvis,
  waist,
  chest,
  neck,
  head,
  upper_arm_l,
  upper_arm_r,
  forearm_l,
  forearm_r,
  hand_l,
  hand_r,
  thigh_l,
  thigh_r,
  shin_l,
  shin_r,
  foot_l,
  foot_r,
  count
};
constexpr std::size_t bone_count = static_cast<std::size_t>(Bone::count);

/// Parts of a body, as bits.
enum Part : unsigned {
  trunk = 1,
  head = 2,
  arm_l = 4,
  arm_r = 8,
  leg_l = 16,
  leg_r = 32,
  extra = 64,
  arms = arm_l | arm_r,
  legs = leg_l | leg_r,
  whole_body = 63
};

/// The part of a limb.
/// @param side 0 left, 1 right
constexpr Part arm(int side) {
  return side == 0 ? arm_l : arm_r;
}
constexpr Part leg(int side) {
  return side == 0 ? leg_l : leg_r;
}
constexpr double sign_of(int side) {
  return side == 0 ? 1 : -1;
}

/// A body as an implicit surface: ellipsoids and tapered limbs that blend into each other, on a
/// skeleton in one pose. It stands on z = 0 and faces -y.
class Sculpture {
 public:
  using Weights = std::array<double, bone_count>;

  Sculpture(const Proportions& proportions, const Pose& pose);

  double height() const { return height_; }
  const Frame& bone(Bone b) const { return frames_[static_cast<std::size_t>(b)]; }
  const Frame& bone(Bone left, int side) const {
    return frames_[static_cast<std::size_t>(left) + static_cast<std::size_t>(side)];
  }
  Point shoulder(int side) const { return bone(Bone::upper_arm_l, side).o; }
  Point wrist(int side) const { return bone(Bone::hand_l, side).o; }
  Point hip(int side) const { return bone(Bone::thigh_l, side).o; }
  Point ankle(int side) const { return bone(Bone::foot_l, side).o; }
  double hip_z() const { return bone(Bone::pelvis).o[2]; }
  /// @return from the hips to the base of the neck [m]
  double trunk_length() const { return (bone(Bone::chest).o[2] - hip_z()) / 0.55; }

  /// @return about the distance [m] of `p` from the surface of these parts, negative inside
  /// @param gradient becomes the gradient there, if given
  double distance(Point p, unsigned parts = whole_body, Point* gradient = nullptr) const;
  /// @return the gradient of `distance`
  Point gradient(Point p, unsigned parts = whole_body) const;
  /// @return the part that is nearest
  Part nearest_part(Point p, unsigned parts = whole_body) const;

  /// @return how far along the limb [m] from its root the nearest point of its axis is; negative
  /// before the root, beyond the wrist or ankle more than the length of the limb
  double along(Part limb, Point p) const;
  /// @return the nearest point of the limb's axis, extended at both ends
  Point axis_point(Part limb, Point p) const;
  /// @return unit direction of the axis there, away from the trunk
  Point axis_direction(Part limb, Point p) const;

  /// How much each bone holds a point; they sum to 1.
  Weights weights(Point p) const;
  /// @return where a point goes that these weights hold, when this body takes the pose of `to`
  Point carried(Point p, const Weights& weights, const Sculpture& to) const;
  /// @return coordinate y of `p`, negative on the front, in the frames of the bones that hold it
  double to_the_back(Point p) const;

  /// A cone with round ends about the axis z of a bone, for garments that stand off: part `extra`.
  /// @param from, to [m] from the bone along z
  /// @param flat thickness along y / width along x
  void add_cone(Bone bone, double from, double to, double radius_from, double radius_to,
                double flat);

  /// The corners of a box around these parts.
  void bounds(unsigned parts, Point& low, Point& high) const;

 private:
  struct Blob {
    Bone bone;
    unsigned part;
    bool round_cone;
    double blend;  // [m] width of the blend with all before it
    Point a, b;    // ends of a cone, or centre and half axes of an ellipsoid; in the bone
    double ra = 0, rb = 0;
    double flat = 1;
    Point axis{};               // unit, of a cone
    Point end{}, world_axis{};  // a and axis in the world
    double length = 0;
    Point centre{};  // of a sphere around it, in the world
    double radius = 0;
  };
  void pose_bones(const Proportions& proportions, const Pose& pose);
  void place(Blob blob);
  /// Whether all of it is farther from `p` than `reach`.
  static bool is_beyond(const Blob& blob, const Point& p, double reach);
  double blob_distance(const Blob& blob, Point p, Point* gradient) const;
  std::array<Point, 3> axis(Part limb) const;

  double height_;
  std::array<Frame, bone_count> frames_{};
  std::vector<Blob> blobs_;
};

}  // namespace weft::lab::test
