#pragma once

#ifndef WEFT_EMBREE_MAJOR
#if __has_include(<embree4/rtcore.h>)
#define WEFT_EMBREE_MAJOR 4
#else
#define WEFT_EMBREE_MAJOR 3
#endif
#endif
#if WEFT_EMBREE_MAJOR >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <limits>
#include <string>
#include <vector>

#include "host/render/picture_camera.hpp"
#include "weft/error.hpp"

/// The surfaces of a picture, and rays that meet them.
namespace weft::io::shading {

struct Surface {
  Float3 front{}, back{};  ///< colours of the two sides, linear
  bool cloth = false;
  bool catcher = false;           ///< shows nothing but the shadows on it
  std::vector<Float3> positions;  ///< scaled to about unit size
  std::vector<Tri> triangles;
  std::vector<Float3> normals;  ///< [3 * triangles] unit, at each corner
  std::vector<float> values;    ///< [3 * triangles] places on the colour map, 0..1; empty: none

  const Float3& position(Index v) const { return positions[static_cast<std::size_t>(v)]; }
};

/// World to a picture of about unit size about the origin, where single precision is fine
/// enough: p -> (p - center) * scale.
struct Placement {
  Vec3<double> center;
  double scale;

  Vec3<double> operator()(const Vec3<double>& p) const { return (p - center) * scale; }

  /// Squares of lengths below this are finite in single precision, areas too.
  static bool holds(const Vec3<double>& placed) {
    return std::abs(placed[0]) < 1e8 && std::abs(placed[1]) < 1e8 && std::abs(placed[2]) < 1e8;
  }
};

/// @throws SceneError if there are more or fewer values than corners
std::vector<Surface> make_surfaces(const Contents& contents, const Placement& place,
                                   const PictureValues* values);

/// Lines as thin prisms whose width in the picture is the same everywhere.
/// @param eye   [m] in the world
/// @param width at distance 1
Surface wire_surface(const std::vector<Wire>& wires, const Placement& place,
                     const Vec3<double>& eye, double width);

struct Hit {
  float distance = 0;
  unsigned surface = RTC_INVALID_GEOMETRY_ID;
  unsigned triangle = 0;
  float u = 0, v = 0;
  Float3 face_normal{};  ///< not unit

  bool any() const { return surface != RTC_INVALID_GEOMETRY_ID; }
};

/// The surfaces, ready to be met by rays. Embree alone knows how.
class RayScene {
 public:
  explicit RayScene(const std::vector<Surface>& surfaces) : device_(rtcNewDevice("threads=1")) {
    if (device_ == nullptr) throw DeviceError("Embree: rtcNewDevice failed");
    scene_ = rtcNewScene(device_);
    // Rays must not slip through where two triangles meet.
    rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
    for (std::size_t i = 0; i < surfaces.size(); ++i) add(surfaces[i], static_cast<unsigned>(i));
    rtcCommitScene(scene_);
    const RTCError error = rtcGetDeviceError(device_);
    if (error == RTC_ERROR_NONE) return;
    release();
    throw DeviceError("Embree: rtcCommitScene failed with error " +
                      std::to_string(static_cast<int>(error)));
  }
  RayScene(const RayScene&) = delete;
  RayScene& operator=(const RayScene&) = delete;
  ~RayScene() { release(); }

  /// First surface on the way.
  Hit first(const Float3& origin, const Float3& direction) const {
    RTCRayHit r;
    r.ray = ray(origin, direction, std::numeric_limits<float>::infinity());
    r.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
#if WEFT_EMBREE_MAJOR >= 4
    rtcIntersect1(scene_, &r);
#else
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene_, &context, &r);
#endif
    return {r.ray.tfar, r.hit.geomID, r.hit.primID,
            r.hit.u,    r.hit.v,      {r.hit.Ng_x, r.hit.Ng_y, r.hit.Ng_z}};
  }

  /// Whether anything stands within `distance`.
  bool blocked(const Float3& origin, const Float3& direction, float distance) const {
    RTCRay r = ray(origin, direction, distance);
#if WEFT_EMBREE_MAJOR >= 4
    rtcOccluded1(scene_, &r);
#else
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded1(scene_, &context, &r);
#endif
    return r.tfar < 0;
  }

 private:
  static RTCRay ray(const Float3& o, const Float3& d, float distance) {
    RTCRay r{};
    r.org_x = o[0], r.org_y = o[1], r.org_z = o[2];
    r.dir_x = d[0], r.dir_y = d[1], r.dir_z = d[2];
    r.tfar = distance;
    r.mask = 0xffffffffu;
    return r;
  }

  void add(const Surface& s, unsigned id) {
    if (s.triangles.empty()) return;
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    void* x = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                      sizeof(Float3), s.positions.size());
    void* t = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                      sizeof(Tri), s.triangles.size());
    if (x != nullptr && t != nullptr) {
      std::copy(s.positions.begin(), s.positions.end(), static_cast<Float3*>(x));
      std::copy(s.triangles.begin(), s.triangles.end(), static_cast<Tri*>(t));
      rtcCommitGeometry(geometry);
      rtcAttachGeometryByID(scene_, geometry, id);
    }
    rtcReleaseGeometry(geometry);
  }

  void release() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }

  RTCDevice device_;
  RTCScene scene_ = nullptr;
};

}  // namespace weft::io::shading
