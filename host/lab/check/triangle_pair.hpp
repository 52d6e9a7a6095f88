#pragma once

#include "host/lab/check/separation.hpp"
#include "weft/core/ids.hpp"
#include "weft/core/vec.hpp"

/// Exact decisions on a pair of triangles. Every function takes finite coordinates as the exact
/// numbers they are, and is right for degenerate triangles as well: those stand for the segment or
/// the point that they cover.
namespace weft::lab {

/// Whether the closed triangles s and t, which share no vertex number, have a common point.
/// @param s, t [m] finite corners
bool triangles_meet(const Corners& s, const Corners& t);

/// Whether the triangles (v, a, b) and (v, c, d) have a common point other than v.
/// @param v, a, b, c, d [m] finite points
bool meet_beyond_vertex(const Vec3<double>& v, const Vec3<double>& a, const Vec3<double>& b,
                        const Vec3<double>& c, const Vec3<double>& d);

/// Whether the triangles (u, v, a) and (u, v, b) have a common point off the segment uv.
/// @param u, v, a, b [m] finite points
bool meet_beyond_edge(const Vec3<double>& u, const Vec3<double>& v, const Vec3<double>& a,
                      const Vec3<double>& b);

/// Whether two triangles of one mesh intersect, by the rules of validate().
/// @param x    [m] positions of the mesh, finite at the corners of s and t
/// @param s, t vertex numbers, all valid for x
bool intersect(const Vec3<double>* x, const Tri& s, const Tri& t);

}  // namespace weft::lab
