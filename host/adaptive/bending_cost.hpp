#pragma once

#include <deque>
#include <vector>

#include "host/adaptive/surface_mesh.hpp"
#include "host/model/plate_notes.hpp"
#include "weft/scene.hpp"

namespace weft {

/// Bending of a scene's materials.
struct BendingLaws {
  Bending kind = Bending::plate;
  std::vector<Mat3<double>> rigidity;  ///< [materials] [N m] of plates
  std::vector<double> mean;            ///< [materials] [N m] of hinges
};
BendingLaws bending_laws(const Scene& scene);

/// A triangle that a change of the mesh would add.
struct FreshTriangle {
  Tri tri;
  Tri corner;
  Index kind;
};

/// Estimates how a change of the mesh changes its bending energy.
///
/// For plates, it evaluates the triangles that change and two rings of neighbours around them. The
/// quadratics of these read a third ring. If the points of a quadratic lie badly, it would read
/// even farther points, which are left out here. The result is therefore an estimate; the energy of
/// the model decides. If the energy of the hinges is slight, it stands for that of the plate: a
/// plate is rarely more than 20 times as stiff.
class BendingCost {
 public:
  /// @param mesh, laws must outlive this
  /// @param joules [J] largest change of energy that one operation may cause
  BendingCost(const SurfaceMesh& mesh, const BendingLaws& laws, double joules)
      : m_(mesh), laws_(laws), slight_(slight_share * joules) {}

  /// Energy after minus energy before, if `fresh` replaces `old`. [J]
  double change(const std::vector<FreshTriangle>& fresh, const std::vector<Index>& old);

  /// Energy of existing triangles and of the neighbours that their shape affects. [J]
  double around(const std::vector<Index>& triangles);

  /// Energy of the hinges of triangles and of the ring around them. A split of these triangles adds
  /// about as much. [J]
  double hinges_at(const std::vector<Index>& triangles);

  /// Drops the cached energies of triangles that were changed or removed, and of their neighbours.
  void forget(const std::vector<Index>& triangles);

  /// Whether this energy of hinges is too small for a closer look.
  bool is_slight(double hinges) const { return hinges < slight_; }

 private:
  static constexpr double slight_share = 0.1;

  void gather(const std::vector<Index>& core, int rings);
  double hinge(Index a, Index b, const FreshTriangle& front, const FreshTriangle& back) const;
  double hinge_there(Index h);
  double hinges_of(const std::vector<FreshTriangle>& core) const;
  double hinges_of(const std::vector<Index>& core);
  double hinges_beyond();
  void take(const FreshTriangle& triangle);
  PlateNote& note_of(Index t);
  double plates_of(const std::vector<FreshTriangle>& core, const std::vector<Index>* numbers);
  FreshTriangle there(Index t) const;

  const SurfaceMesh& m_;
  const BendingLaws& laws_;
  double slight_;             ///< [J] of hinges: below this, plates are not evaluated
  std::vector<Index> rings_;  ///< triangles around the core, nearest first
  std::vector<std::size_t> ring_end_;
  std::vector<double> hinge_;         ///< [half-edges] [J] cached energy of its edge; NaN: unknown
  std::vector<unsigned char> taken_;  ///< [triangles] in the core or in a ring
  // working memory of plates_of()
  std::vector<PlateTriangle> triangles_;
  std::vector<Vec3<double>> positions_;  ///< of the vertices of the patch, in the order of take()
  std::vector<Index> number_,
      numbered_;  ///< [vertices] number in the patch, -1: none; vertices with one
  std::vector<PlateNote*> patch_notes_;  ///< of triangles_
  std::deque<PlateNote> notes_;
  std::vector<Index> note_;  ///< [triangles] into notes_; -1: none
};

}  // namespace weft
