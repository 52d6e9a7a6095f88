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

/// A triangle that is to take the place of another.
struct FreshTriangle {
  Tri tri;
  Tri corner;
  Index kind;
};

/// What a change of a mesh makes of the energy of bending.
///
/// Of plates: looks at the triangles that change and at two rings of neighbours around them, whose
/// quadratics read a third. A quadratic whose points lie badly may read farther: what that leaves
/// out is why this is an estimate, and the model's energy the measure. Where the hinges say that
/// hardly anything is bent, what they say is all that is asked: a plate is rarely more than 20
/// times as stiff as they are.
class BendingCost {
 public:
  /// @param mesh, laws must outlive this
  /// @param joules change of energy that matters
  BendingCost(const SurfaceMesh& mesh, const BendingLaws& laws, double joules)
      : m_(mesh), laws_(laws), slight_(slight_share * joules) {}

  /// After less before, if `fresh` takes the place of `old`. [J]
  double change(const std::vector<FreshTriangle>& fresh, const std::vector<Index>& old);

  /// Of triangles that are there and of what their shape acts on. [J]
  double around(const std::vector<Index>& triangles);

  /// Energy of the hinges of triangles and of the ring around them, which is about what a split of
  /// these adds. [J]
  double hinges_at(const std::vector<Index>& triangles);

  /// These triangles have changed, or are gone: what has been found out about them and their
  /// neighbours holds no longer.
  void forget(const std::vector<Index>& triangles);

  /// Whether so much in hinges is too little to be looked at closer.
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
  double slight_;             ///< [J] of hinges: what is bent less is not looked at closer
  std::vector<Index> rings_;  ///< triangles around the core, nearest first
  std::vector<std::size_t> ring_end_;
  std::vector<double> hinge_;         ///< [half-edges] [J] of its edge; not a number: not known
  std::vector<unsigned char> taken_;  ///< [triangles] in the core or in a ring
  // of plates_of()
  std::vector<PlateTriangle> triangles_;
  std::vector<Vec3<double>> positions_;  ///< of vertices in the order in which they came up
  std::vector<Index> number_,
      numbered_;                         ///< [vertices] theirs there, -1: none; those that have one
  std::vector<PlateNote*> patch_notes_;  ///< of triangles_
  std::deque<PlateNote> notes_;
  std::vector<Index> note_;  ///< [triangles] into notes_; -1: none
};

}  // namespace weft
