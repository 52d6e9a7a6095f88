#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "weft/core/ids.hpp"
#include "weft/core/mat.hpp"
#include "weft/core/vec.hpp"

namespace weft {

struct PatchNotes;

/// What a curved rest shape y adds to the energy of PlateMatrix:
///   - sum over triangles t and vertices v of x_v . R_t force_tv,  + energy
/// R_t is the rotation of t from the rest shape to where it is now (elements/triangle_frame.hpp),
/// the forces are what K y consists of, each term with its triangle, those of an edge half with
/// either neighbour; energy is y^T K y / 2. With the terms of triangles alone that would be the
/// integral of (s - R s_y)^T D (s - R s_y) / 2, s the second derivatives: curvature is measured
/// against that at rest, in a frame that turns with the triangle. This form was chosen because K
/// stays the constant matrix of the flat sheet, which is what the solver and its preconditioner
/// read, and because it has an exact gradient, so that momentum and energy are kept: energy and
/// gradient vanish at the rest shape however that is moved. The matrix leaves out how forces turn:
/// at the rest shape it is stiffer than the exact one against turning, and softer elsewhere, but
/// more than half of it where stretching does not help, so that Newton's method converges.
struct PlateShape {
  std::vector<Tri> corners;            ///< of the triangles that are curved at rest or near such
  std::vector<Mat2<double>> inv_rest;  ///< [1/m] inverse edges in material space
  std::vector<Offset> offset;          ///< [triangles + 1] into the next two
  std::vector<Index> vertex;           ///< ascending in a triangle
  std::vector<Vec3<double>> force;     ///< [N] in the frame of the triangle at rest
  double energy = 0;                   ///< [J]
};

/// Bending of thin plates as a quadratic form: with x one coordinate of all vertices the energy is
/// x^T K x / 2, summed over the three coordinates. For isometric motion of a sheet that is flat at
/// rest it is the integral of k^T D k / 2 over the curvatures k = (k11, k22, k12), since the normal
/// part of the second derivatives is all there is of them then.
struct PlateMatrix {
  std::vector<Offset> row_offset;  ///< [vertices + 1]
  std::vector<Index> column;       ///< ascending in a row; a row sums to zero
  std::vector<double> stiffness;   ///< [N/m] K
  std::vector<double> damping;     ///< [N s/m] K with each triangle's share times its Rayleigh b
  PlateShape shape;                ///< no triangles where all is flat at rest
};

/// A triangle of the plate. What it points at has to outlive it.
struct PlateTriangle {
  Tri v;
  std::array<Vec2<double>, 3> rest;  ///< [m] its corners in its own piece of material space
  const Mat3<double>* rigidity;      ///< [N m] D
  double damping = 0;                ///< [s] Rayleigh b
  bool held = false;                 ///< all corners are prescribed: it cannot bend
  /// [m] its corners in a rest shape that may be curved; null: flat
  const std::array<Vec3<double>, 3>* shape = nullptr;
  /// Its corners as numbers of vertices before seams were welded: triangles of one piece have them
  /// in common. -1: as v
  Tri source{{-1, -1, -1}};
};

/// Second derivatives of a triangle are those of the quadratic through its corners and three points
/// around it: the opposite corners of its neighbours, others where it has fewer or they lie badly.
/// On most meshes the quadratics of two neighbours do not have one slope on their common edge.
/// Therefore the energy has the terms of the symmetric interior penalty method as well, with J the
/// jump of the normal slope at the middle of the edge and M the mean bending moment across it,
///   - L M J + p J^2 / 2,   p = L^2 / 4 sum over both triangles of n D_n / A,
/// where n is the number of a triangle's inner edges and D_n its rigidity across the edge: the
/// least p for which Cauchy's inequality shows that K is not indefinite on any mesh. Without them
/// the plate is too soft on some meshes, however fine they are. Neighbours that meet in a seam
/// are unfolded into one plane: seams are flat at rest, those of curved pieces too. Where more than
/// two triangles meet at an edge, the two of one piece are neighbours, and no others are.
/// A held triangle has a plane and no energy. The quadratic of a free neighbour takes its slope in
/// the middle of their edge, in the place of a point: J is zero there, so that no term is needed,
/// and a clamped edge is as exact as the inside. Were that point the held triangle's corner, the
/// curvature there would be the mean of the clamp's, zero, and the sheet's, as if the sheet were
/// clamped a third of a cell further back.
/// @cite engel2002, C0 interior penalty; li2020, reconstruction from patches
PlateMatrix make_plate_matrix(Index vertex_count, const std::vector<PlateTriangle>& triangles);

/// x^T K x / 2 over all three coordinates, and what the rest shape adds. [J]
/// @param positions [>= vertices] [m]
double plate_energy(const PlateMatrix& matrix, const std::vector<Vec3<double>>& positions);

/// What some triangles and the inner edges at them add to that energy, without the matrix. [J]
/// @param triangles flat at rest: first those that count, then their neighbours, then what
///                  surrounds these: quadratics look up to three triangles far
/// @param counted   how many count
/// @param positions [>= vertices] [m]
/// @param notes     read, and added to; null: none
double plate_energy(const std::vector<PlateTriangle>& triangles, std::size_t counted,
                    const std::vector<Vec3<double>>& positions, PatchNotes* notes = nullptr);

}  // namespace weft
