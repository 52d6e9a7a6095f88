#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "host/state/rank_geometry.hpp"
#include "host/state/store.hpp"
#include "weft/state/contact.hpp"

/// Where attempts fail, at the start of the attempt: the state that a failed step leaves. [m]
namespace weft {

/// The point of the first primitive that meets the second one.
template <class T>
std::optional<Vec3<double>> place_of(Store<T>& store, const Collision& collision);

/// The first vertex whose motion is not finite.
template <class T>
std::optional<Vec3<double>> place_not_finite(Store<T>& store, const RankMotion<T>& motion);

/// The first collision from `first` on with a prescribed vertex that pinches cloth. The order of
/// collisions does not depend on the number of ranks, that of zones does.
/// @param pinched prescribed vertices, see ImpactZones::pinched
template <class T>
std::optional<Vec3<double>> pinched_place(Store<T>& store, const std::vector<Collision>& collisions,
                                          std::size_t first, const std::vector<Index>& pinched);

}  // namespace weft
