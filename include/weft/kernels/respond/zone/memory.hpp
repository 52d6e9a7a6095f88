#pragma once

#include <cstddef>
#include <initializer_list>
#include <type_traits>

#include "weft/core/hd.hpp"
#include "weft/core/ids.hpp"
#include "weft/core/vec.hpp"

namespace weft {

/// Most phases of a sweep in which constraints are relaxed side by side.
inline constexpr Index zone_phases_max = 64;

/// Most constraints of a face whose change is found by factors of its matrix. Larger matrices leave
/// the fast memory of a GPU's processor.
inline constexpr Index zone_factor_max = 128;

/// One row of the programme of an impact zone: n . sum of w_j u_j >= wanted.
struct ZoneConstraint {
  Index v[4];  ///< by their place in the zone
  double w[4];
  Vec3<double> n;
  double wanted;      ///< [m] offset less the gap where the vertices would be without response
  double tolerance;   ///< [m] by which the gap may miss the offset
  double diagonal;    ///< [1/kg] of A M^-1 A^T
  double multiplier;  ///< [kg m] impulse times step
};

/// Working memory of one zone, cut from one block. A collision has up to four vertices, and becomes
/// up to four constraints.
struct ZoneMemory {
  ZoneConstraint* constraint;  ///< [constraints]
  Vec3<double>* x;             ///< [vertices] [m]
  Vec3<double>* nearly;        ///< [vertices] [m] what an attempt came to
  Vec3<double>* u;             ///< [vertices] [m] M^-1 A^T of the multipliers
  Vec3<double>* trial;         ///< [vertices] [m] the same of other multipliers
  Vec3<double>* u_before;      ///< [vertices] [m] u a sweep at once before
  double* mass_inv;            ///< [vertices] [1/kg] 0: infinite mass
  double* direction;           ///< [constraints] as are the six that follow
  double* search;
  double* residual;
  double* product;
  double* cut;
  double* projected;
  double* before;       ///< multipliers a sweep at once before
  double* factor;       ///< [factor_size collisions] lower triangle, and the right side as a row
  Offset* corner;       ///< [4 collisions] by vertex, then by 4 collision + corner; see corner_of
  Index* vertex;        ///< [vertices] number in the mesh, ascending
  Index* local;         ///< [4 collisions] place of each corner's vertex in the zone
  Index* corner_begin;  ///< [vertices + 1] into corner
  Index* constraint_begin;  ///< [collisions + 1]
  Index* face;              ///< [constraints] list of those that a step may change; other lists
  Index* phase;             ///< [constraints] -1: none yet
  Index* order;             ///< [constraints] by phase
  Index* phase_begin;       ///< [zone_phases_max + 2] into order
  unsigned char* on_face;   ///< [constraints]
  unsigned char* touched;   ///< [vertices]

  static constexpr std::size_t most = 4;  ///< vertices, constraints and corners of a collision
  /// Of `factor`, for each collision: enough for a face of as many constraints as collisions, and
  /// of zone_factor_max.
  static constexpr std::size_t factor_size = (zone_factor_max + 4) / 2;
  static constexpr std::size_t collision_bytes =
      most * (sizeof(ZoneConstraint) + 5 * sizeof(Vec3<double>) + 8 * sizeof(double) +
              sizeof(Offset) + 6 * sizeof(Index) + 2) +
      factor_size * sizeof(double) +
      2 * sizeof(Index);  // one of them for constraint_begin, one to end at a multiple of 8
  static constexpr std::size_t zone_bytes = (2 + zone_phases_max + 2) * sizeof(Index);
  static_assert(collision_bytes % sizeof(double) == 0 && zone_bytes % sizeof(double) == 0);

  /// @param memory     [collisions * collision_bytes + zone_bytes] aligned as double
  /// @param collisions of the zone
  WEFT_HD static ZoneMemory cut_from(std::byte* memory, Index collisions) noexcept {
    const auto count = static_cast<std::size_t>(collisions);
    ZoneMemory m{};
    const auto take = [&memory](auto*& array, std::size_t size) {
      array = reinterpret_cast<std::remove_reference_t<decltype(array)>>(memory);
      memory += size * sizeof *array;
    };
    take(m.constraint, most * count);
    for (Vec3<double>** array : {&m.x, &m.nearly, &m.u, &m.trial, &m.u_before})
      take(*array, most * count);
    for (double** array : {&m.mass_inv, &m.direction, &m.search, &m.residual, &m.product, &m.cut,
                           &m.projected, &m.before})
      take(*array, most * count);
    take(m.factor, factor_size * count);
    take(m.corner, most * count);
    for (Index** array : {&m.vertex, &m.local, &m.face, &m.phase, &m.order})
      take(*array, most * count);
    take(m.corner_begin, most * count + 1);
    take(m.constraint_begin, count + 1);
    take(m.phase_begin, static_cast<std::size_t>(zone_phases_max) + 2);
    take(m.on_face, most * count);
    take(m.touched, most * count);
    return m;
  }

  /// 4 collision + corner of an entry of `corner`.
  WEFT_HD static Index corner_of(Offset entry) noexcept {
    return static_cast<Index>(entry & 0xffffffff);
  }
  WEFT_HD static Offset entry_of(Index vertex, Index corner) noexcept {
    return (static_cast<Offset>(vertex) << 32) | corner;
  }
};

}  // namespace weft
