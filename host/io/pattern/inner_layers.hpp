#pragma once

#include <vector>

#include "host/io/pattern/garment.hpp"

namespace weft::io {

/// Garments that a garment is worn over: all of lower layers, as they are sewn.
class InnerLayers {
 public:
  /// @param body [m] y up, kept by reference; may be empty: then nothing is known of what is
  /// outside
  explicit InnerLayers(const Mesh& body) : body_(body) {}

  bool empty() const { return mesh_.triangles.empty(); }
  /// [m] y up; fronts look away from the body
  const Mesh& mesh() const { return mesh_; }

  /// @param garment sewn, see relax_start()
  void add(const Garment& garment);
  /// Moves the panels of a garment away from the body until they stand outside of all that they
  /// cover. Each keeps its shape and its direction.
  void stand_outside(Garment& garment) const;
  /// Moves cloth that lies beneath inner layers, or meets them, to their outer side.
  /// @param cloth triangles
  /// @param x     [m] vertices of the cloth
  void lift(const std::vector<Tri>& cloth, std::vector<Vec3<double>>& x) const;

 private:
  Vec3<double> outward(const Garment& garment, const GarmentPanel& panel) const;

  const Mesh& body_;
  Mesh mesh_;
};

}  // namespace weft::io
