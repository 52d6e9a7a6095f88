#pragma once

#include <memory>
#include <vector>

#include "weft/scene.hpp"

/// How far a run is from another one of the same scene, on whatever mesh.
namespace weft::lab {

/// A reference carried over to the vertices of another mesh of the same cloths. Where triangles are
/// the same, vertices correspond by number; otherwise by their place in material space, connected
/// piece by connected piece, in the order of the pieces' first vertices.
class Resampling {
 public:
  /// Both meshes hold all cloths of a frame.
  Resampling(const Mesh& reference, const Mesh& mesh);

  /// Whether vertices correspond at all; not if one mesh has no material coordinates, or another
  /// number of pieces.
  bool known() const { return known_; }

  /// Where the reference is, at each vertex of the mesh. [m]
  /// @param positions [m] of the reference
  /// @pre known()
  std::vector<Vec3<double>> positions(const std::vector<Vec3<double>>& positions) const;

 private:
  struct Place {
    Tri corners;
    Vec3<double> weights;
  };
  void by_material(const Mesh& reference, const Mesh& mesh);

  bool known_ = false;
  std::vector<Place> places_;
};

/// Root of the mean squared distance, weighted by the area that belongs to each vertex in the first
/// of the two shapes. [m]
double mean_distance(const std::vector<Tri>& triangles, const std::vector<Vec3<double>>& a,
                     const std::vector<Vec3<double>>& b);

/// Sum of the differences between the angles at inner edges over the sum of the reference's angles:
/// equation (17) of Liang & Lin 2018. Zero where the reference is flat and the other one too;
/// infinity where the reference alone is flat.
double curvature_error(const std::vector<Tri>& triangles,
                       const std::vector<Vec3<double>>& reference,
                       const std::vector<Vec3<double>>& positions);

/// The farthest that a vertex of one surface is from the other surface, both ways. [m]
/// @pre both have triangles, and finite positions
double hausdorff_distance(const Mesh& a, const Mesh& b);

/// What chaos leaves alone: mean place, and spread about it along each axis, weighted by area.
struct Statistics {
  Vec3<double> mean{0, 0, 0};    ///< [m]
  Vec3<double> spread{0, 0, 0};  ///< [m] root mean square
};
Statistics statistics(const Mesh& mesh);

/// The largest difference of any of the numbers. [m]
double difference(const Statistics& a, const Statistics& b);

/// Means over several starts, and their standard errors, which are 0 for a single one.
struct MeanStatistics {
  Statistics mean;
  Statistics error;
};
/// @pre there is one
MeanStatistics mean_statistics(const std::vector<Statistics>& of_starts);

/// The largest standard error of the difference of any two of the numbers. [m]
double difference_error(const MeanStatistics& a, const MeanStatistics& b);

/// Diagonal of the box around the positions. [m]
double diagonal(const std::vector<Vec3<double>>& positions);

/// Richardson's extrapolation: what a quantity that has errors of `order` in the step tends to.
/// @param coarse of twice the step of `fine`, as many
std::vector<Vec3<double>> extrapolated(const std::vector<Vec3<double>>& coarse,
                                       const std::vector<Vec3<double>>& fine, int order);

}  // namespace weft::lab
