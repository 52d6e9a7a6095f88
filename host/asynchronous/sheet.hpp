#pragma once

#include <cstdint>
#include <vector>

#include "host/asynchronous/trajectory.hpp"
#include "host/asynchronous/triangle_block.hpp"
#include "host/asynchronous/workers.hpp"
#include "host/model/material_rows.hpp"
#include "host/model/model.hpp"
#include "weft/core/mat.hpp"

namespace weft {

/// The forces inside of cloth, stretching and bending at once: each triangle's and hinge's share is
/// computed once, and each vertex sums its own in the order of their numbers. Several threads store
/// the shares first, so that they never meet; one sums on the way, to the same bits.
class Sheet {
 public:
  /// @param place [vertices of the model] their numbers here
  /// @param order [vertices of the model] the other way round
  Sheet(const Model& model, const std::vector<Index>& place, const std::vector<Index>& order);

  /// Adds the impulses of internal forces and of Rayleigh damping over `h` to the velocities of
  /// cloth vertices.
  /// @param plate bending while the vertices are held that are so now, in the order used here;
  ///                 empty where bending goes by hinges
  /// @pre all cloth vertices have been advanced to one time
  void kick(double h, const PlateMatrix& plate, VertexMotion& motion, Workers& workers);

  /// Elements that one kick computes: triangles, hinges and rows of the plate.
  std::size_t element_count() const { return triangles_.size() + hinges_.size() + mass_.size(); }

  /// [s] half of the longest step at which the sheet at rest is stable when all its forces are
  /// integrated in one, damping counted: cloth may be stretched to some 1.6 times its lengths.
  ///   step = (sqrt(1 + z^2) - z) / omega,  z = b omega / 2
  /// with b the largest Rayleigh coefficient and omega^2 a bound of the largest eigenvalue of
  /// M^-1 K: Gershgorin's for the plate; for elements the largest of any one of them with a share
  /// of its corners' masses (the Rayleigh quotient of the whole is a mean of theirs).
  double stable_step(const PlateMatrix& plate) const;

 private:
  double membrane_eigenvalue() const;
  double hinge_eigenvalue() const;
  double plate_eigenvalue(const PlateMatrix& plate) const;
  void make_blocks();
  /// Number of elements: blocks of triangles, then hinges.
  std::size_t item_count() const { return blocks_.size() + hinges_.size(); }
  /// Calls to(corner, vertex, gradient) for the corners of a run of elements.
  template <class To>
  void gradients(std::size_t first, std::size_t last, const VertexMotion& motion,
                 const To& to) const;
  void triangle_gradient(std::size_t t, const VertexMotion& motion, Vec3<double> (&g)[3]) const;
  void hinge_gradient(std::size_t h, const VertexMotion& motion, Vec3<double> (&g)[4]) const;
  void pack(const VertexMotion& motion, Workers& workers);
  Vec3<double> plate_gradient(std::size_t i, const PlateMatrix& plate) const;

  std::vector<Tri> triangles_;
  std::vector<TriangleBlock> blocks_;   ///< of four triangles that follow each other
  std::vector<Mat2<double>> inv_rest_;  ///< [1/m]
  std::vector<double> area_;            ///< [m^2]
  std::vector<Index> material_;
  MaterialRows<double> materials_;
  std::vector<Hinge> hinges_;
  std::vector<double> hinge_stiffness_, hinge_rest_, hinge_damping_;
  std::vector<double> hinge_slope_sq_;  ///< [1/m^2] of the angle's gradient where flat
  std::vector<double> mass_;            ///< [cloth vertices] [kg]
  std::vector<double> damping_mass_;    ///< [cloth vertices] [1/s]
  std::vector<Vec3<double>> share_;     ///< [N] of corners: of triangles, then of hinges
  std::vector<Vec3<double>> gradient_;  ///< [cloth vertices] [N] where one thread sums
  std::vector<std::size_t> offset_;     ///< [cloth vertices + 1] into corner_
  std::vector<std::uint32_t> corner_;   ///< into share_, ascending
  /// [cloth vertices] x + b v before a kick, and v; the latter only where b is not one for all
  std::vector<Simd> point_, rate_;
  bool one_damping_ = true;  ///< all triangles have the same Rayleigh coefficient
  double damping_ = 0;       ///< [s] largest Rayleigh coefficient
};

/// The plate's matrix with vertices renumbered.
/// @param place, order as for Sheet
PlateMatrix renumbered(const PlateMatrix& plate, const std::vector<Index>& place,
                       const std::vector<Index>& order);

}  // namespace weft
