#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "host/io/pattern/surface_tree.hpp"
#include "weft/scene.hpp"

namespace weft::io {

/// Keeps cloth that is moved step by step from entering a body: triangles that do not meet the body
/// never come to do so. Those that begin within it may go where they like until they are free.
/// Steps must be short against the thickness of the body's limbs, since only their ends are looked
/// at.
class BodyGuard {
 public:
  /// @param body  [m] kept by reference; may have no triangles
  /// @param cloth triangles of the cloth
  /// @param x     [m] where its vertices are now
  /// @param clearance [m] steps do not lead closer to the body than this
  BodyGuard(const Mesh& body, std::vector<Tri> cloth, const std::vector<Vec3<double>>& x,
            double clearance = 0);

  /// [vertices] 1: of a triangle that meets the body
  std::vector<unsigned char> vertices_within() const;

  /// Takes back the step of vertices whose triangles would enter the body.
  /// @param before [vertices] [m]
  /// @param now    [vertices] [m] where the step leads
  void guard(const std::vector<Vec3<double>>& before, std::vector<Vec3<double>>& now);

 private:
  bool meets_body(const Tri& t, const std::vector<Vec3<double>>& x) const;
  bool comes_close(const Tri& t, const std::vector<Vec3<double>>& x) const;

  std::vector<Tri> cloth_;
  std::vector<std::vector<Index>> triangles_of_;  ///< [vertices]
  std::vector<unsigned char> free_;               ///< [cloth triangles] 1: does not meet the body
  std::optional<SurfaceTree> body_;
  double clearance_;
};

}  // namespace weft::io
