#include "host/render/picture_values.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>

#include "host/render/picture_camera.hpp"
#include "host/render/picture_scene.hpp"
#include "weft/elements/distance.hpp"

namespace weft::io {
namespace {

constexpr float none = std::numeric_limits<float>::quiet_NaN();

template <class T>
const T& at(const std::vector<T>& list, Index i) {
  return list[static_cast<std::size_t>(i)];
}

/// Largest singular value of the deformation gradient.
/// @param e deformed edges [m], @param m material edges [m], both from the first corner
double largest_stretch(const Vec3<double> (&e)[2], const Vec2<double> (&m)[2]) {
  const double det = m[0][0] * m[1][1] - m[1][0] * m[0][1];
  if (!(det != 0)) return std::numeric_limits<double>::quiet_NaN();
  const Vec3<double> fu = (e[0] * m[1][1] - e[1] * m[0][1]) * (1 / det);
  const Vec3<double> fv = (e[1] * m[0][0] - e[0] * m[1][0]) * (1 / det);
  const double a = dot(fu, fu), b = dot(fu, fv), c = dot(fv, fv);
  return std::sqrt(0.5 * (a + c) + std::hypot(0.5 * (a - c), b));
}

/// All surfaces of a frame as one list of triangles, in a tree that finds the near ones.
class Neighbours {
 public:
  struct Face {
    const NamedMesh* mesh;
    Tri corners;
  };

  Neighbours(const std::vector<NamedMesh>& cloths, const std::vector<NamedMesh>& obstacles) {
    for (const auto* list : {&cloths, &obstacles})
      for (const NamedMesh& named : *list)
        for (const Tri& t : named.mesh.triangles)
          if (std::all_of(t.v, t.v + 3, [&](Index v) {
                return shading::Placement::holds(at(named.mesh.positions, v));
              }))
            faces_.push_back({&named, t});
    build();
  }
  Neighbours(const Neighbours&) = delete;
  Neighbours& operator=(const Neighbours&) = delete;
  ~Neighbours() { release(); }

  /// Distance of a vertex to the nearest face that counts, at most `radius`.
  /// @param apart [m] in the material, of its own cloth what is nearer does not count
  double nearest(const NamedMesh& mesh, Index vertex, double radius, double apart) const {
    Query query{this, &mesh, vertex, at(mesh.mesh.positions, vertex), radius, apart * apart};
    if (!shading::Placement::holds(query.position)) return radius;
    RTCPointQuery sphere{};
    sphere.x = static_cast<float>(query.position[0]);
    sphere.y = static_cast<float>(query.position[1]);
    sphere.z = static_cast<float>(query.position[2]);
    // The tree knows the positions in single precision only.
    sphere.radius = static_cast<float>(radius + 4e-7 * (radius + length(query.position)));
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(scene_, &sphere, &context, &Neighbours::visit, &query);
    return query.distance;
  }

 private:
  struct Query {
    const Neighbours* of;
    const NamedMesh* mesh;
    Index vertex;
    Vec3<double> position;
    double distance;
    double apart_sq;
  };

  static bool visit(RTCPointQueryFunctionArguments* arguments) {
    auto& query = *static_cast<Query*>(arguments->userPtr);
    const Face& face = query.of->faces_[arguments->primID];
    if (face.mesh == query.mesh && is_own(query, face)) return false;
    const auto& x = face.mesh->mesh.positions;
    const Vec3<double> corners[4] = {query.position, at(x, face.corners.v[0]),
                                     at(x, face.corners.v[1]), at(x, face.corners.v[2])};
    query.distance =
        std::min(query.distance, std::sqrt(vertex_triangle<double>(corners).distance_sq));
    return false;
  }

  /// Whether a face of the vertex's own cloth is so near in the material that it is near anyway.
  static bool is_own(const Query& query, const Face& face) {
    const Mesh& mesh = query.mesh->mesh;
    const bool has_material =
        mesh.material_triangles.empty() && mesh.material.size() == mesh.positions.size();
    for (const Index v : face.corners.v)
      if (v == query.vertex ||
          (has_material &&
           length_sq(at(mesh.material, v) - at(mesh.material, query.vertex)) < query.apart_sq))
        return true;
    return false;
  }

  void build() {
    device_ = rtcNewDevice("threads=1");
    if (device_ == nullptr) throw DeviceError("Embree: rtcNewDevice failed");
    scene_ = rtcNewScene(device_);
    if (!faces_.empty()) add_faces();
    rtcCommitScene(scene_);
    const RTCError error = rtcGetDeviceError(device_);
    if (error == RTC_ERROR_NONE) return;
    release();
    throw DeviceError("Embree: rtcCommitScene failed with error " +
                      std::to_string(static_cast<int>(error)));
  }

  void add_faces() {
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* x = static_cast<Vec3<float>*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                sizeof(Vec3<float>), 3 * faces_.size()));
    auto* t = static_cast<unsigned*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(unsigned), faces_.size()));
    if (x != nullptr && t != nullptr) {
      for (std::size_t i = 0; i < 3 * faces_.size(); ++i) {
        const Face& face = faces_[i / 3];
        x[i] = vec_cast<float>(at(face.mesh->mesh.positions, face.corners.v[i % 3]));
        t[i] = static_cast<unsigned>(i);
      }
      rtcCommitGeometry(geometry);
      rtcAttachGeometryByID(scene_, geometry, 0);
    }
    rtcReleaseGeometry(geometry);
  }

  void release() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }

  std::vector<Face> faces_;
  RTCDevice device_ = nullptr;
  RTCScene scene_ = nullptr;
};

/// Numbers at vertices, handed to the corners.
template <class F>
std::vector<float> corner_values(const Mesh& mesh, F&& value_of_vertex) {
  std::vector<float> at_vertices;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    at_vertices.push_back(static_cast<float>(value_of_vertex(static_cast<Index>(v))));
  std::vector<float> values;
  for (const Tri& t : mesh.triangles)
    for (const Index v : t.v) values.push_back(at(at_vertices, v));
  return values;
}

}  // namespace

CornerValues strain_values(const std::vector<NamedMesh>& cloths) {
  CornerValues all;
  for (const NamedMesh& named : cloths) {
    const Mesh& mesh = named.mesh;
    const auto& places = mesh.material_triangles.empty() ? mesh.triangles : mesh.material_triangles;
    std::vector<float>& values = all.emplace_back(3 * mesh.triangles.size(), none);
    if (mesh.material.empty()) continue;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      const Index *t = mesh.triangles[i].v, *p = places[i].v;
      Vec3<double> e[2];
      Vec2<double> m[2];
      for (int k = 0; k < 2; ++k) {
        e[k] = at(mesh.positions, t[k + 1]) - at(mesh.positions, t[0]);
        m[k] = at(mesh.material, p[k + 1]) - at(mesh.material, p[0]);
      }
      std::fill_n(values.begin() + static_cast<std::ptrdiff_t>(3 * i), 3,
                  static_cast<float>(largest_stretch(e, m) - 1));
    }
  }
  return all;
}

CornerValues height_values(const std::vector<NamedMesh>& cloths) {
  CornerValues all;
  for (const NamedMesh& named : cloths)
    all.push_back(corner_values(named.mesh, [&](Index v) {
      const double z = at(named.mesh.positions, v)[2];
      return std::isfinite(z) ? z : static_cast<double>(none);
    }));
  return all;
}

CornerValues contact_values(const std::vector<NamedMesh>& cloths,
                            const std::vector<NamedMesh>& obstacles, double thickness,
                            double reach) {
  const Neighbours neighbours(cloths, obstacles);
  CornerValues all;
  for (const NamedMesh& named : cloths)
    all.push_back(corner_values(named.mesh, [&](Index v) {
      return neighbours.nearest(named, v, reach * thickness, 1.5 * reach * thickness) / thickness;
    }));
  return all;
}

}  // namespace weft::io
