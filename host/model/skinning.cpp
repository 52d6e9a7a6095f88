#include "host/model/skinning.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "weft/core/assert.hpp"

namespace weft {
namespace {

Vec3<double> between(const Vec3<double>& a, const Vec3<double>& b, double s) {
  return a + (b - a) * s;
}
Quaternion between(const Quaternion& a, const Quaternion& b, double s) {
  return slerp(a, b, s);
}

template <class Value>
Value value_at(const Track<Value>& track, double time) {
  WEFT_ASSERT(!track.empty());
  const auto next = std::upper_bound(track.begin(), track.end(), time,
                                     [](double t, const auto& key) { return t < key.first; });
  if (next == track.begin()) return track.front().second;
  const auto& before = *(next - 1);
  if (next == track.end() || time == before.first) return before.second;
  return between(before.second, next->second, (time - before.first) / (next->first - before.first));
}

}  // namespace

Quaternion operator*(const Quaternion& a, const Quaternion& b) {
  return {a.w * b.w - dot(a.v, b.v), b.v * a.w + a.v * b.w + cross(a.v, b.v)};
}

Quaternion rotation_about(const Vec3<double>& axis, double angle) {
  return {std::cos(angle / 2), axis * std::sin(angle / 2)};
}

Quaternion normalized(const Quaternion& q) {
  const double norm = std::sqrt(q.w * q.w + dot(q.v, q.v));
  if (!(norm > 0) || !std::isfinite(norm)) return {};
  return {q.w / norm, q.v * (1 / norm)};
}

Quaternion slerp(const Quaternion& a, Quaternion b, double s) {
  // b and -b are the same rotation; take the one that is nearer.
  if (a.w * b.w + dot(a.v, b.v) < 0) b = {-b.w, -b.v};
  // The angle from its sine where it is small: there the cosine holds half as many digits.
  const Quaternion d{b.w - a.w, b.v - a.v};
  const double half_chord = std::sqrt(d.w * d.w + dot(d.v, d.v)) / 2;
  const double angle = 2 * std::asin(std::min(half_chord, 1.0));
  if (!(angle > 0)) return a;
  const double sine = std::sin(angle);
  const double share_a = std::sin((1 - s) * angle) / sine;
  const double share_b = std::sin(s * angle) / sine;
  return {a.w * share_a + b.w * share_b, a.v * share_a + b.v * share_b};
}

Mat3<double> matrix_of(const Quaternion& q) {
  const double x = q.v[0];
  const double y = q.v[1];
  const double z = q.v[2];
  const double w = q.w;
  return {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),  //
           2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),  //
           2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
}

Affine operator*(const Affine& a, const Affine& b) {
  return {a.linear * b.linear, a.linear * b.translate + a.translate};
}

Affine axes_to_world(bool y_up, double scale) {
  Affine result;
  if (y_up) result.linear = {{1, 0, 0, 0, 0, -1, 0, 1, 0}};
  result.linear *= scale;
  return result;
}

std::vector<Affine> node_frames(const std::vector<SkeletonNode>& nodes, double time) {
  std::vector<Affine> frames(nodes.size());
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    const SkeletonNode& node = nodes[n];
    Affine local = node.local;
    if (node.animated) {
      local.linear = matrix_of(value_at(node.rotate, time));
      const Vec3<double> scale = value_at(node.scale, time);
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) local.linear(r, c) *= scale[c];
      local.translate = value_at(node.translate, time);
    }
    WEFT_ASSERT(node.parent < static_cast<Index>(n));
    frames[n] = node.parent < 0 ? local : frames[static_cast<std::size_t>(node.parent)] * local;
  }
  return frames;
}

void SkinnedDeformation::positions(double time, Span<Vec3<double>> out) const {
  WEFT_ASSERT(out.size() == vertex_count());
  const std::vector<Affine> frames =
      node_frames(skin_.nodes, skin_.clip_start + clip_time(playback_, skin_.duration, time));
  std::vector<Affine> bones;
  bones.reserve(skin_.bones.size());
  for (const Bone& bone : skin_.bones)
    bones.push_back(skin_.to_world * frames[static_cast<std::size_t>(bone.node)] * bone.offset);
  for (std::size_t v = 0; v < out.size(); ++v) {
    Vec3<double> x{0, 0, 0};
    for (Offset i = skin_.first_influence[v]; i < skin_.first_influence[v + 1]; ++i) {
      const Influence& influence = skin_.influences[static_cast<std::size_t>(i)];
      x += bones[static_cast<std::size_t>(influence.bone)](skin_.rest[v]) * influence.weight;
    }
    out[v] = x;
  }
}

std::uint64_t SkinnedDeformation::checksum() const {
  Checksum checksum;
  const auto add_affine = [&](const Affine& a) {
    checksum.add(a.linear.e, sizeof a.linear.e);
    checksum.add(a.translate.e, sizeof a.translate.e);
  };
  add_to(checksum, playback_);
  for (const SkeletonNode& node : skin_.nodes) {
    checksum.add(node.parent);
    checksum.add(static_cast<int>(node.animated));
    add_affine(node.local);
    for (const auto* track : {&node.translate, &node.scale})
      for (const auto& [time, value] : *track) {
        checksum.add(time);
        checksum.add(value.e, sizeof value.e);
      }
    for (const auto& [time, value] : node.rotate) {
      checksum.add(time);
      checksum.add(value.w);
      checksum.add(value.v.e, sizeof value.v.e);
    }
  }
  for (const Bone& bone : skin_.bones) {
    checksum.add(bone.node);
    add_affine(bone.offset);
  }
  checksum.add(skin_.rest);
  checksum.add(skin_.first_influence);
  for (const Influence& influence : skin_.influences) {
    checksum.add(influence.bone);
    checksum.add(influence.weight);
  }
  add_affine(skin_.to_world);
  checksum.add(skin_.clip_start);
  checksum.add(skin_.duration);
  return checksum.value();
}

}  // namespace weft
