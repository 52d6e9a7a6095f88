#pragma once

#include <cmath>

#include "weft/elements/pressure.hpp"
#include "weft/kernels/assemble/contacts.hpp"
#include "weft/kernels/assemble/wind.hpp"

namespace weft {

/// Work that prescribed vertices do on the cloth through contacts, and wind, pressure and constant
/// forces on its free vertices, in a motion that is over: in double, a partial sum for each
/// `partial_items` of the contacts, then the triangles, then the vertices. Forces of contacts and
/// wind are those at the end of the motion, as the implicit step has them; that of pressure is
/// integrated along straight paths. Reads: positions and velocities of all vertices. Writes:
/// partials. Order: fixed within a partial; every rank may compute all. Ghosts: all vertices.
/// Flags: none.
template <class T>
struct AssembleExternalWork {
  Span<const Contact<T>> contacts;
  Span<const Tri> triangles;                         ///< of the cloth, if wind or pressure act
  Span<const T> pressure;                            ///< [triangles] [Pa]; empty: none
  Span<const unsigned char> fixed;                   ///< [vertices] 1: its position is prescribed
  Span<const Vec3<T>> positions_t0;                  ///< [m]
  Span<const Vec3<T>> positions_t1;                  ///< [m]
  Span<const Vec3<T>> velocities_t0, velocities_t1;  ///< [cloth vertices] [m/s]
  T density{};                                       ///< these three as in AssembleWind
  T drag{};
  Vec3<T> wind{};
  Span<const Vec3<T>> accelerations{};  ///< [cloth vertices] [m/s^2] forces over mass; empty: none
  Span<const T> mass{};                 ///< [cloth vertices] [kg]
  Index partial_items = 1024;
  Span<double> partial{};  ///< [J]

  Index items() const {
    return static_cast<Index>(contacts.size() + triangles.size() + accelerations.size());
  }
  Index partials() const { return (items() + partial_items - 1) / partial_items; }
};

template <class T>
WEFT_HD Vec3<double> displacement_of(const AssembleExternalWork<T>& a, Index vertex) noexcept {
  return vec_cast<double>(a.positions_t1.data()[vertex] - a.positions_t0.data()[vertex]);
}

/// What holds the prescribed corners of a contact against its force. [J]
template <class T>
WEFT_HD double work_at_contact(const AssembleExternalWork<T>& a, const Contact<T>& c) noexcept {
  Vec3<double> moved{};
  for (int j = 0; j < 4; ++j)
    if (a.fixed.data()[c.v[j]] != 0)
      moved += static_cast<double>(c.w[j]) * displacement_of(a, c.v[j]);
  if (!(length_sq(moved) > 0)) return 0;
  const ContactMotion<T> m = contact_motion(c, a.positions_t1, a.positions_t0);
  const ContactWeights<T> k = contact_weights(c, m);
  const Vec3<T> force =
      (k.push * (c.thickness - m.gap)) * c.n - friction_force(k.drag, m.displacement);
  return -dot(vec_cast<double>(force), moved);
}

/// Wind and pressure on the free corners of a triangle. [J]
template <class T>
WEFT_HD double work_at_triangle(const AssembleExternalWork<T>& a, Index t) noexcept {
  const Tri& tri = a.triangles.data()[t];
  Vec3<double> moved{};  // a third of what the free corners move
  Vec3<double> x0[3];
  for (int c = 0; c < 3; ++c) {
    const Vec3<double> d = displacement_of(a, tri.v[c]);
    x0[c] = vec_cast<double>(a.positions_t0.data()[tri.v[c]]);
    if (a.fixed.data()[tri.v[c]] == 0) moved += (1.0 / 3) * d;
  }
  double work = 0;
  if (!a.pressure.empty()) {
    // The area vector is quadratic in time: Simpson's rule is exact.
    Vec3<double> x[3];
    Vec3<double> mean{};
    for (int s = 0; s < 3; ++s) {
      for (int c = 0; c < 3; ++c)
        x[c] = x0[c] + (0.5 * static_cast<double>(s)) * displacement_of(a, tri.v[c]);
      mean += (s == 1 ? 4.0 / 6 : 1.0 / 6) * (0.5 * cross(x[1] - x[0], x[2] - x[0]));
    }
    work += static_cast<double>(a.pressure.data()[t]) * dot(mean, moved);
  }
  if (!(a.density > T(0) || a.drag > T(0))) return work;
  const Vec3<double> twice_area = cross(x0[1] - x0[0], x0[2] - x0[0]);
  const double size = length(twice_area);
  if (!(size > 0)) return work;
  const Vec3<double> n = (1 / size) * twice_area;
  const Vec3<double> wind = vec_cast<double>(a.wind);
  const double speed =
      std::fabs(dot(wind - vec_cast<double>(mean_of_corners(a.velocities_t0, tri)), n));
  const Vec3<double> u = wind - vec_cast<double>(mean_of_corners(a.velocities_t1, tri));
  const Vec3<double> across = dot(u, n) * n;
  const Vec3<double> force = (size / 2) * (static_cast<double>(a.density) * speed * across +
                                           static_cast<double>(a.drag) * (u - across));
  return work + dot(force, moved);
}

/// A constant force on a free vertex. [J]
template <class T>
WEFT_HD double work_at_vertex(const AssembleExternalWork<T>& a, Index v) noexcept {
  if (a.fixed.data()[v] != 0) return 0;
  return static_cast<double>(a.mass.data()[v]) *
         dot(vec_cast<double>(a.accelerations.data()[v]), displacement_of(a, v));
}

/// Item i: contacts first, then triangles, then vertices.
template <class T>
WEFT_HD double assemble_external_work(const AssembleExternalWork<T>& a, Index i) noexcept {
  const auto contacts = static_cast<Index>(a.contacts.size());
  const auto triangles = static_cast<Index>(a.triangles.size());
  if (i < contacts) return work_at_contact(a, a.contacts.data()[i]);
  if (i < contacts + triangles) return work_at_triangle(a, i - contacts);
  return work_at_vertex(a, i - contacts - triangles);
}

template <class T>
void run(OnHost, Queue& queue, const AssembleExternalWork<T>& args);
template <class T>
void run(OnCuda, Queue& queue, const AssembleExternalWork<T>& args);

}  // namespace weft
