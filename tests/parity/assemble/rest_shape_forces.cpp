#include "weft/kernels/assemble/rest_shape_forces.hpp"

#include "tests/parity/support.hpp"

namespace weft::parity {
namespace {

using Long = long double;
using LongVec = Vec3<Long>;

/// Orthonormal axes of a triangle by its polar decomposition: C = F^T F, S = sqrt(C), F S^-1.
struct PlainAxes {
  LongVec axis[3];

  PlainAxes(const LongVec x[3], const Long inv_rest[4]) {
    const LongVec a = x[1] - x[0], b = x[2] - x[0];
    const LongVec f0 = a * inv_rest[0] + b * inv_rest[2], f1 = a * inv_rest[1] + b * inv_rest[3];
    const Long det = length(cross(f0, f1));
    const Long scale = std::sqrt(dot(f0, f0) + dot(f1, f1) + 2 * det);
    const Long s00 = (dot(f0, f0) + det) / scale, s01 = dot(f0, f1) / scale,
               s11 = (dot(f1, f1) + det) / scale;
    const Long s = s00 * s11 - s01 * s01;
    axis[0] = f0 * (s11 / s) - f1 * (s01 / s);
    axis[1] = f1 * (s00 / s) - f0 * (s01 / s);
    axis[2] = cross(axis[0], axis[1]);
  }
};

/// A crumpled sheet; each triangle has forces on the vertices of one that is near.
template <class T>
struct RestShapeForcesCase {
  using Scalar = T;
  Random random{42};
  Sheet<T> sheet{random};
  std::vector<Mat2<T>> inv_rest;
  std::vector<Offset> offset{0};
  std::vector<Index> vertex;
  std::vector<Vec3<T>> force;

  RestShapeForcesCase() {
    for (std::size_t t = 0; t < sheet.triangles.size(); ++t) {
      const T a = random.uniform<T>(8, 12), b = random.uniform<T>(-2, 2),
              c = random.uniform<T>(8, 12);
      inv_rest.push_back(t % 2 == 0 ? Mat2<T>{{a, b, T(0), c}} : Mat2<T>{{a, -c, T(0), c}});
      // Forces that sum to zero, on up to five vertices.
      const std::size_t count = t % 5 == 0 ? 0 : 2 + t % 4;
      Vec3<T> sum{};
      for (std::size_t k = 0; k < count; ++k) {
        const Tri& near = sheet.triangles[(t + k / 3) % sheet.triangles.size()];
        vertex.push_back(near.v[k % 3]);
        force.push_back(k + 1 < count ? random.vector<T>(-1, 1) : -sum);
        sum += force.back();
      }
      offset.push_back(static_cast<Offset>(vertex.size()));
    }
  }

  Outputs compute(Device& device, Index parts) const {
    const auto corners = upload(device, sheet.triangles);
    const auto inv_rest_d = upload(device, inv_rest);
    const auto offset_d = upload(device, offset);
    const auto vertex_d = upload(device, vertex);
    const auto force_d = upload(device, force), x = upload(device, sheet.positions);
    const std::size_t count = sheet.triangles.size();
    const Buffer<Vec3<T>> axes(device, 3 * count), corner_force(device, 3 * count);
    for (const auto& [begin, size] : parts_of(static_cast<Index>(count), parts)) {
      const auto b = static_cast<std::size_t>(begin), n = static_cast<std::size_t>(size);
      launch(device.compute(),
             AssembleRestShapeForces<T>{
                 corners.span().subspan(b, n), inv_rest_d.span().subspan(b, n),
                 offset_d.span().subspan(b, n + 1), vertex_d.span(), force_d.span(), x.span(),
                 axes.span().subspan(3 * b, 3 * n), corner_force.span().subspan(3 * b, 3 * n)});
    }
    return {output("axes", download(axes)), output("corner force", download(corner_force))};
  }

  /// The work of the torque in the frame's rotation, by differences.
  Outputs reference() const {
    std::vector<Vec3<double>> axes, corner_force;
    for (std::size_t t = 0; t < sheet.triangles.size(); ++t) {
      LongVec x[3];
      for (int j = 0; j < 3; ++j) x[j] = at(sheet.triangles[t].v[j]);
      Long rest[4];
      for (int k = 0; k < 4; ++k) rest[k] = static_cast<Long>(inv_rest[t].e[k]);
      const PlainAxes frame(x, rest);
      for (const LongVec& axis : frame.axis) axes.push_back(vec_cast<double>(axis));
      LongVec torque{};
      for (auto e = static_cast<std::size_t>(offset[t]);
           e < static_cast<std::size_t>(offset[t + 1]); ++e) {
        LongVec f{};
        for (int c = 0; c < 3; ++c) f += frame.axis[c] * static_cast<Long>(force[e][c]);
        torque += cross(f, at(vertex[e]));
      }
      for (int j = 0; j < 3; ++j) {
        Vec3<double> g{};
        for (int c = 0; c < 3; ++c)
          g[c] = static_cast<double>(dot(turn(frame, x, rest, j, c), torque));
        corner_force.push_back(g);
      }
    }
    return {output("axes", axes), output("corner force", corner_force)};
  }
  LongVec at(Index v) const { return vec_cast<Long>(sheet.positions[static_cast<std::size_t>(v)]); }

  /// Rotation of the frame a metre that a corner moves: half the sum of axis x change of axis.
  static LongVec turn(const PlainAxes& frame, const LongVec x[3], const Long rest[4], int corner,
                      int component) {
    const Long h = 1e-5L;
    const auto moved = [&](Long by) {
      LongVec y[3] = {x[0], x[1], x[2]};
      y[corner][component] += by;
      return PlainAxes(y, rest);
    };
    const PlainAxes far_low = moved(-2 * h), low = moved(-h), high = moved(h),
                    far_high = moved(2 * h);
    LongVec w{};
    for (int k = 0; k < 3; ++k) {
      const LongVec change = (far_low.axis[k] - far_high.axis[k]) * (1 / (12 * h)) +
                             (high.axis[k] - low.axis[k]) * (8 / (12 * h));
      w += cross(frame.axis[k], change) * 0.5L;
    }
    return w;
  }
};

using Cases = testing::Types<RestShapeForcesCase<float>, RestShapeForcesCase<double>>;
INSTANTIATE_TYPED_TEST_SUITE_P(AssembleRestShapeForces, KernelParity, Cases);

}  // namespace
}  // namespace weft::parity
