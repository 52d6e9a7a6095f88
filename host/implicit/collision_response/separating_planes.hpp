#pragma once

#include <array>
#include <set>
#include <vector>

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"
#include "weft/state/contact.hpp"

namespace weft {

/// Ends of a motion that keep pairs of primitives on their sides of planes. Each plane has a fixed
/// direction, along which it separates its pair at the start, and moves along it at a constant
/// speed. So a pair never meets on straight ways to ends on its sides of the plane, and motion
/// along the plane is not restricted.
///
/// Planes are kept one after the other, in several sweeps (Gauss-Seidel). A plane between something
/// prescribed and something free lies at the prescribed end; other planes lie in the middle.
template <class T>
class SeparatingPlanes {
 public:
  /// @param from      [vertices] [m] start, free of collisions; must outlive the motion
  /// @param to        [vertices] [m] targets
  /// @param held      [vertices] 1: prescribed; must outlive the motion
  /// @param thickness [m]
  void begin(const std::vector<Vec3<T>>& from, const std::vector<Vec3<T>>& to,
             const std::vector<unsigned char>& held, double thickness);

  /// Adds a plane for each pair that has none.
  void add(Span<const Collision> collisions);

  /// Moves ends to their sides of the planes. If too many planes depend on each other, or exclude
  /// each other, some are not kept.
  /// @param held_too moves prescribed ends as well, at most back to where they are at the start
  void keep(bool held_too);

  /// [vertices] [m]
  const std::vector<Vec3<double>>& ends() const noexcept { return ends_; }

 private:
  struct Plane {
    Index v[4];
    Index first;     ///< number of vertices on the upper side
    Vec3<double> n;  ///< upwards
    double gap;      ///< [m] between the sides, to be kept
  };

  bool keep(const Plane& plane, bool held_too);
  bool held(Index v) const { return (*held_)[static_cast<std::size_t>(v)] != 0; }

  const std::vector<Vec3<T>>* from_ = nullptr;
  const std::vector<unsigned char>* held_ = nullptr;
  double thickness_ = 0;
  std::vector<Vec3<double>> ends_;
  std::vector<Plane> planes_;
  std::set<std::array<Index, 5>> pairs_;  ///< that have a plane
};

}  // namespace weft
