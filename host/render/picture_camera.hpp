#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "host/geometry/aabb.hpp"
#include "host/render/picture.hpp"

/// What a picture shows and from where: shared by the camera and the shading, no interface.
namespace weft::io::shading {

using Float3 = Vec3<float>;

constexpr double pi = 3.14159265358979323846;

template <class T>
Vec3<T> normalized(const Vec3<T>& a) {
  const T l = length(a);
  return l > T(0) ? a * (T(1) / l) : Vec3<T>{0, 0, 1};
}

inline Float3 tint(const Float3& a, const Float3& b) {
  return {a[0] * b[0], a[1] * b[1], a[2] * b[2]};
}

inline Float3 mix(const Float3& a, const Float3& b, float t) {
  return a * (1 - t) + b * t;
}

/// Finite, and so small that its square is finite too.
inline bool usable(const Vec3<double>& p) {
  return std::abs(p[0]) < 1e100 && std::abs(p[1]) < 1e100 && std::abs(p[2]) < 1e100;
}

/// Right-handed frame whose third axis is a given unit vector.
struct Frame {
  Float3 x, y, z;

  explicit Frame(const Float3& axis)
      : x(normalized(std::abs(axis[0]) < 0.7f ? Float3{0, axis[2], -axis[1]}
                                              : Float3{-axis[2], 0, axis[0]})),
        y(cross(axis, x)),
        z(axis) {}
};

/// Unit axes of the picture, in the world.
struct View {
  Vec3<double> right, up, forward;

  /// @throws SceneError if there is no direction from the eye, or it is along `up`
  View(const Vec3<double>& eye, const Vec3<double>& look_at, const Vec3<double>& upwards);
};

/// @throws SceneError if an option is out of range
void check_options(const PictureOptions& o);

/// Half the height of the picture at distance 1.
double half_height(const PictureOptions& o);

/// A mesh without its broken triangles.
struct Part {
  const NamedMesh* source;
  std::vector<Tri> triangles;
  std::vector<std::size_t> numbers;  ///< of these triangles in the mesh
  Aabb box;

  template <class F>
  void for_each_corner(F&& f) const {
    for (const Tri& t : triangles)
      for (const Index v : t.v) f(source->mesh.positions[static_cast<std::size_t>(v)]);
  }
};

/// Whether a word of the name is, or begins with, plane, floor or ground.
bool named_like_floor(const Part& part);

struct Contents {
  std::vector<Part> cloths, obstacles;
  double cloth_size = 0;             ///< [m] diagonal of the box of all cloths; 0: none
  std::vector<Vec3<double>> framed;  ///< [m] corners that the picture must show, at least one
  Aabb framed_box;
  double lowest = 0;  ///< [m]

  /// Much larger than the cloths, so that framing it would make them too small to see.
  bool is_wide(const Part& obstacle) const {
    return cloth_size > 0 &&
           obstacle.box.diagonal() > (named_like_floor(obstacle) ? 1.5 : 2.5) * cloth_size;
  }
  /// A wide level floor only catches shadows, so that its border does not cross the picture.
  bool is_catcher(const Part& obstacle) const {
    return is_wide(obstacle) && named_like_floor(obstacle) &&
           obstacle.box.size()[2] < 1e-3 * obstacle.box.diagonal();
  }
};

/// @throws SceneError if there is nothing to see, or a triangle names a vertex that is not there
/// @param subject of the motion that the frame belongs to; null: none
Contents make_contents(const std::vector<NamedMesh>& cloths,
                       const std::vector<NamedMesh>& obstacles, const PictureSubject* subject);

/// Null: none.
const PictureSubject* subject_of(const PictureOptions& options);

/// frame_camera() for contents that are known.
PictureOptions framed_options(const Contents& contents, const PictureOptions& options);

}  // namespace weft::io::shading
