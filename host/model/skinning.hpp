#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "host/model/deformation.hpp"
#include "weft/core/mat.hpp"

/// Skeletons of animated nodes, and surfaces bound to them.
namespace weft {

/// Unit quaternion of a rotation: w + (x, y, z).
struct Quaternion {
  double w = 1;
  Vec3<double> v{0, 0, 0};
};

/// Rotation a after rotation b.
Quaternion operator*(const Quaternion& a, const Quaternion& b);

/// Rotation about a unit axis.
/// @param angle [rad]
Quaternion rotation_about(const Vec3<double>& axis, double angle);

/// The same rotation with length 1; none if `q` is zero or not finite.
Quaternion normalized(const Quaternion& q);

/// On the shortest arc from a to b at constant angular speed (Shoemake 1985).
/// @param s 0: a, 1: b
Quaternion slerp(const Quaternion& a, Quaternion b, double s);

Mat3<double> matrix_of(const Quaternion& q);

/// x -> linear * x + translate
struct Affine {
  Mat3<double> linear = Mat3<double>::identity();
  Vec3<double> translate{0, 0, 0};

  Vec3<double> operator()(const Vec3<double>& x) const { return linear * x + translate; }
};

/// a after b
Affine operator*(const Affine& a, const Affine& b);

/// From a file's units and axes to metres with z up.
/// @param y_up  the file's y axis points up, its z axis towards the viewer; false: z up already
/// @param scale [m] a unit of the file
Affine axes_to_world(bool y_up, double scale);

/// Values at increasing times; linear between them (rotations: slerp), held outside.
template <class Value>
using Track = std::vector<std::pair<double, Value>>;

/// One node of a skeleton: a joint, or anything that carries a mesh or other nodes.
struct SkeletonNode {
  std::string name;
  Index parent = -1;  ///< number of an earlier node; -1: none
  Affine local;       ///< into the parent's frame, where not animated
  bool animated = false;
  /// If animated: local = translate * rotate * scale, each from its track; none of them is empty.
  Track<Vec3<double>> translate;  ///< times in seconds of the clip
  Track<Quaternion> rotate;
  Track<Vec3<double>> scale;
};

/// What a surface is bound to: mesh space -> node's space at rest -> wherever the node goes.
struct Bone {
  Index node = 0;
  Affine offset;  ///< from mesh space to that of the node
};

/// Share of a bone in where a vertex goes.
struct Influence {
  Index bone = 0;
  double weight = 1;
};

/// A surface on a skeleton: linear blend skinning,
///   x = sum over influences of weight * world(node) * offset * rest
/// of which the sum of the weights is 1 at each vertex.
struct Skin {
  std::vector<SkeletonNode> nodes;  ///< parents before their children
  std::vector<Bone> bones;
  std::vector<Vec3<double>> rest;       ///< [vertices] in mesh space
  std::vector<Offset> first_influence;  ///< [vertices + 1] into `influences`
  std::vector<Influence> influences;
  Affine to_world;        ///< applied last: units and axes, [m]
  double clip_start = 0;  ///< [s] first time of the tracks that is played
  double duration = 0;    ///< [s] of the clip
};

/// A skin with its triangles.
struct SkinnedSurface {
  Skin skin;
  std::vector<Tri> triangles;  ///< corners in Skin::rest
};

/// Where each node's space goes at `time`.
/// @param time [s] of the tracks
/// @return     [nodes] into the space of the skeleton
std::vector<Affine> node_frames(const std::vector<SkeletonNode>& nodes, double time);

/// Exact at any time: nothing is sampled beforehand.
class SkinnedDeformation : public Deformation {
 public:
  SkinnedDeformation(Skin skin, Playback playback) : skin_(std::move(skin)), playback_(playback) {}

  std::size_t vertex_count() const { return skin_.rest.size(); }
  const Skin& skin() const { return skin_; }

  /// @pre out.size() == vertex_count()
  void positions(double time, Span<Vec3<double>> out) const override;
  std::uint64_t checksum() const override;
  double last_time() const override { return clip_end(playback_, skin_.duration); }

 private:
  Skin skin_;
  Playback playback_;
};

}  // namespace weft
