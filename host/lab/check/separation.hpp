#pragma once

#include <array>

#include "weft/core/vec.hpp"

/// Quick rejection in double precision. A plane that provably separates two triangles, with every
/// rounding accounted for, settles most pairs without exact arithmetic. `false` only ever means
/// "not shown": the exact test must decide.
namespace weft::lab {

/// Corners of a triangle in world space.
using Corners = std::array<Vec3<double>, 3>;

/// Whether two triangles are certainly disjoint as closed sets.
/// @param s, t [m] finite corners, of any shape, degenerate ones included
bool certainly_apart(const Corners& s, const Corners& t) noexcept;

/// Whether the triangles (v, a, b) and (v, c, d) certainly have no common point but v.
/// @param v, a, b, c, d [m] finite points
bool certainly_apart_beyond(const Vec3<double>& v, const Vec3<double>& a, const Vec3<double>& b,
                            const Vec3<double>& c, const Vec3<double>& d) noexcept;

}  // namespace weft::lab
