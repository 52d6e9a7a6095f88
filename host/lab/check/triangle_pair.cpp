#include "host/lab/check/triangle_pair.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/intersections.h>

#include <algorithm>
#include <array>
#include <variant>

namespace weft::lab {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Segment = Kernel::Segment_3;
using Triangle = Kernel::Triangle_3;

/// A convex set with at most three corners; CGAL asks that segments and triangles be proper.
using Hull = std::variant<Point, Segment, Triangle>;

Point point(const Vec3<double>& x) {
  return {x[0], x[1], x[2]};
}

Hull hull_of(const Point& p, const Point& q) {
  if (p == q) return p;
  return Segment(p, q);
}

Hull hull_of(const Point& p, const Point& q, const Point& r) {
  if (!CGAL::collinear(p, q, r)) return Triangle(p, q, r);
  // Along a line the lexicographic order of points is their order on the line.
  const auto [lo, hi] = std::minmax({p, q, r}, [](const Point& a, const Point& b) {
    return CGAL::compare_lexicographically(a, b) == CGAL::SMALLER;
  });
  return hull_of(lo, hi);
}

bool meet(const Hull& s, const Hull& t) {
  return std::visit([](const auto& a, const auto& b) { return CGAL::do_intersect(a, b); }, s, t);
}

/// Whether all the points lie strictly on one side of the plane pqr.
template <class... Points>
bool strictly_on_one_side(const Point& p, const Point& q, const Point& r, const Points&... points) {
  const std::array sides{CGAL::orientation(p, q, r, points)...};
  return sides[0] != CGAL::COPLANAR &&
         std::all_of(sides.begin(), sides.end(), [&](auto side) { return side == sides[0]; });
}

/// Whether the segment vp and the triangle (v, c, d) have a common point other than v.
bool spoke_meets(const Point& v, const Point& p, const Point& c, const Point& d) {
  if (p == v) return false;
  if (!CGAL::collinear(v, c, d))
    // The ray from v through p leaves the common part at p or on the edge cd.
    return meet(p, Triangle(v, c, d)) || meet(Segment(v, p), Segment(c, d));
  for (const Point& q : {c, d})
    if (q != v && (meet(p, Segment(v, q)) || meet(q, Segment(v, p)))) return true;
  return false;
}

/// Whether the segments va and vb leave the segment uv, a proper one on the same line, at its end
/// v.
bool both_leave_at(const Point& u, const Point& v, const Point& a, const Point& b) {
  return CGAL::collinear_are_strictly_ordered_along_line(u, v, a) &&
         CGAL::collinear_are_strictly_ordered_along_line(u, v, b);
}

/// Whether a and b lie on opposite sides of the line uv in a projection along an axis: then the
/// triangles meet on that line alone. This settles flat components of cloth, where the orientation
/// in space is too close to zero to be told without exact arithmetic. Only the widest projection of
/// the first triangle is tried.
bool unfolded_in_projection(const Vec3<double>& u, const Vec3<double>& v, const Vec3<double>& a,
                            const Vec3<double>& b) {
  const Vec3<double> n = cross(v - u, a - u);
  int drop = 0;
  for (int k = 1; k < 3; ++k)
    if (std::abs(n[k]) > std::abs(n[drop])) drop = k;
  const int i = (drop + 1) % 3, j = (drop + 2) % 3;
  const auto flat = [&](const Vec3<double>& x) { return Kernel::Point_2(x[i], x[j]); };
  const auto side_a = CGAL::orientation(flat(u), flat(v), flat(a));
  const auto side_b = CGAL::orientation(flat(u), flat(v), flat(b));
  return side_a != CGAL::COLLINEAR && side_a == -side_b;
}

/// Distinct vertex numbers of a triangle, those that another triangle has as well in front.
struct Numbers {
  Index v[3];
  int shared;
  int count;
};

bool has(const Tri& t, Index i) {
  return t.v[0] == i || t.v[1] == i || t.v[2] == i;
}

/// Numbers of t in increasing order, first those shared with `other`. A place left over by a number
/// that t names twice repeats the first one: such a triangle is the segment between the two.
Numbers shared_first(const Tri& t, const Tri& other) {
  Numbers r{{t.v[0], t.v[1], t.v[2]}, 0, 0};
  const auto before = [&](Index i, Index j) {
    const bool i_shared = has(other, i), j_shared = has(other, j);
    return i_shared != j_shared ? i_shared : i < j;
  };
  std::sort(r.v, r.v + 3, before);
  Index* end = std::unique(r.v, r.v + 3);
  r.count = static_cast<int>(end - r.v);
  r.shared = static_cast<int>(std::count_if(r.v, end, [&](Index i) { return has(other, i); }));
  std::fill(end, r.v + 3, r.v[0]);
  return r;
}

}  // namespace

bool triangles_meet(const Corners& s, const Corners& t) {
  if (certainly_apart(s, t)) return false;
  return meet(hull_of(point(s[0]), point(s[1]), point(s[2])),
              hull_of(point(t[0]), point(t[1]), point(t[2])));
}

bool meet_beyond_vertex(const Vec3<double>& v_in, const Vec3<double>& a_in,
                        const Vec3<double>& b_in, const Vec3<double>& c_in,
                        const Vec3<double>& d_in) {
  if (certainly_apart_beyond(v_in, a_in, b_in, c_in, d_in)) return false;
  const Point v = point(v_in), a = point(a_in), b = point(b_in), c = point(c_in), d = point(d_in);
  if (strictly_on_one_side(v, a, b, c, d) || strictly_on_one_side(v, c, d, a, b)) return false;
  if (CGAL::collinear(v, a, b)) return spoke_meets(v, a, c, d) || spoke_meets(v, b, c, d);
  if (CGAL::collinear(v, c, d)) return spoke_meets(v, c, a, b) || spoke_meets(v, d, a, b);
  // The common part is convex and holds v; if it holds more, it reaches the edge opposite v in one
  // of the two, and neither of these edges passes through v.
  return meet(hull_of(a, b), Triangle(v, c, d)) || meet(hull_of(c, d), Triangle(v, a, b));
}

bool meet_beyond_edge(const Vec3<double>& u_in, const Vec3<double>& v_in, const Vec3<double>& a_in,
                      const Vec3<double>& b_in) {
  if (unfolded_in_projection(u_in, v_in, a_in, b_in)) return false;
  const Point u = point(u_in), v = point(v_in), a = point(a_in), b = point(b_in);
  // Two planes that differ meet in the line uv alone, and the triangles meet that line in uv.
  if (CGAL::orientation(u, v, a, b) != CGAL::COPLANAR) return false;
  if (u == v) return spoke_meets(u, a, u, b);
  const bool flat_a = CGAL::collinear(u, v, a), flat_b = CGAL::collinear(u, v, b);
  if (flat_a && flat_b) return both_leave_at(u, v, a, b) || both_leave_at(v, u, a, b);
  if (flat_a || flat_b) return false;
  return CGAL::coplanar_orientation(u, v, a, b) == CGAL::POSITIVE;
}

bool intersect(const Vec3<double>* x, const Tri& s, const Tri& t) {
  const Numbers ns = shared_first(s, t), nt = shared_first(t, s);
  if (ns.shared == 0)
    return triangles_meet({x[s.v[0]], x[s.v[1]], x[s.v[2]]}, {x[t.v[0]], x[t.v[1]], x[t.v[2]]});
  if (ns.shared == 3) return true;
  if (ns.shared == ns.count || nt.shared == nt.count) return false;  // one is a side of the other
  if (ns.shared == 2) return meet_beyond_edge(x[ns.v[0]], x[ns.v[1]], x[ns.v[2]], x[nt.v[2]]);
  return meet_beyond_vertex(x[ns.v[0]], x[ns.v[1]], x[ns.v[2]], x[nt.v[1]], x[nt.v[2]]);
}

}  // namespace weft::lab
