#pragma once

#include "weft/elements/hinge.hpp"

// The exact Hessian of a hinge, which no kernel needs: what the positive one of the library leaves
// out is measured against it.

namespace weft {
namespace detail {

/// The matrix of v -> a x v.
template <class T>
constexpr Mat3<T> cross_matrix(const Vec3<T>& a) noexcept {
  return {{T(0), -a[2], a[1], a[2], T(0), -a[0], -a[1], a[0], T(0)}};
}

/// Derivatives of one opposite corner's angle gradient t = -|e| n / |n|^2, n = side (e x arm), and
/// of foot = arm . e / |e|^2.
template <class T>
struct HingeWing {
  Mat3<T> by0, by1, by_opposite;  ///< dt / dx0, dt / dx1, dt / d(opposite corner)
  Vec3<T> t, foot_by0, foot_by1;
  T foot;
};

template <class T>
HingeWing<T> hinge_wing(const Vec3<T>& edge, T edge_sq, T edge_length, const Vec3<T>& arm,
                        const Vec3<T>& normal, T normal_sq, T side) noexcept {
  HingeWing<T> w;
  const T scale = edge_length / normal_sq;
  w.t = normal * -scale;
  // d(n / |n|^2) = (I - 2 n n^T / |n|^2) dn / |n|^2, and n . (a x v) = (n x a) . v
  const Vec3<T> twice = normal * (T(2) / normal_sq);
  const T signed_scale = side * scale;
  w.by_opposite = (outer(twice, cross(normal, edge)) - cross_matrix(edge)) * signed_scale;
  w.by1 = (cross_matrix(arm) - outer(twice, cross(normal, arm))) * signed_scale -
          outer(normal, edge) * (T(1) / (normal_sq * edge_length));
  w.by0 = T(-1) * (w.by1 + w.by_opposite);
  w.foot = dot(arm, edge) / edge_sq;
  w.foot_by1 = (arm - edge * (T(2) * w.foot)) * (T(1) / edge_sq);
  w.foot_by0 = -(w.foot_by1 + edge * (T(1) / edge_sq));
  return w;
}

template <class T>
void hinge_angle_hessian(const HingeFrame<T>& f, Mat3<T> h[10]) noexcept {
  const HingeWing<T> a =
      hinge_wing(f.edge, f.edge_sq, f.edge_length, f.arm2, f.normal2, f.normal2_sq, T(1));
  const HingeWing<T> b =
      hinge_wing(f.edge, f.edge_sq, f.edge_length, f.arm3, f.normal3, f.normal3_sq, T(-1));
  const Mat3<T> h00 = a.by0 * (a.foot - T(1)) + outer(a.t, a.foot_by0) + b.by0 * (b.foot - T(1)) +
                      outer(b.t, b.foot_by0);
  const Mat3<T> h11 =
      T(-1) * (a.by1 * a.foot + outer(a.t, a.foot_by1) + b.by1 * b.foot + outer(b.t, b.foot_by1));
  // The blocks on the diagonal are symmetric up to rounding; make them so exactly.
  h[0] = (h00 + transpose(h00)) * T(0.5);
  h[1] = a.by1 * (a.foot - T(1)) + outer(a.t, a.foot_by1) + b.by1 * (b.foot - T(1)) +
         outer(b.t, b.foot_by1);
  h[2] = transpose(a.by0);
  h[3] = transpose(b.by0);
  h[4] = (h11 + transpose(h11)) * T(0.5);
  h[5] = transpose(a.by1);
  h[6] = transpose(b.by1);
  h[7] = (a.by_opposite + transpose(a.by_opposite)) * T(0.5);
  h[8] = Mat3<T>{};
  h[9] = (b.by_opposite + transpose(b.by_opposite)) * T(0.5);
}

}  // namespace detail

/// Exact Hessian of hinge_angle; the parameters are the same.
/// @param h [rad/m^2] out, blocks (0,0), (0,1), (0,2), (0,3), (1,1), (1,2), (1,3), (2,2), (2,3),
///          (3,3); (j,i) = (i,j)^T; zeros where a triangle has no area
/// @cite tamstorf2013; derived here from the gradient by way of the feet of the heights
template <class T>
void hinge_angle_hessian(const Vec3<T> x[4], Mat3<T> h[10]) noexcept {
  const auto f = detail::hinge_frame(x);
  if (f.valid) {
    detail::hinge_angle_hessian(f, h);
  } else {
    for (int i = 0; i < 10; ++i) h[i] = Mat3<T>{};
  }
}

/// Exact Hessian of hinge_energy, indefinite in general; the parameters are the same.
///   2 coefficient (grad theta grad theta^T + (theta - theta_rest) Hessian of theta)
/// @param h [N/m] out, blocks in the order of hinge_angle_hessian
template <class T>
void hinge_hessian(const Vec3<T> x[4], T theta_rest, T coefficient, Mat3<T> h[10]) noexcept {
  Vec3<T> t[4];
  const T bend = hinge_angle_gradient(x, t) - theta_rest;
  hinge_angle_hessian(x, h);
  int block = 0;
  for (int i = 0; i < 4; ++i)
    for (int j = i; j < 4; ++j, ++block)
      h[block] = (outer(t[i], t[j]) + h[block] * bend) * (T(2) * coefficient);
}

}  // namespace weft
