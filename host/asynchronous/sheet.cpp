#include "host/asynchronous/sheet.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "weft/core/at.hpp"
#include "weft/elements/hinge.hpp"

namespace weft {
namespace {

/// Fewer than these are not worth a thread: some 5 microseconds each.
constexpr std::size_t elements_a_thread = 24, sums_a_thread = 128, points_a_thread = 2048;

/// Stress of a material, and how it changes as the strain does, both at rates of their own.
struct StressAndRate {
  detail::Symmetric2<double> stress, rate;
};

/// Stress [N/m] and its rate [N/(m s)] at a Green strain that changes by `rate` [1/s].
StressAndRate respond(const MaterialRow<double>& m, const detail::Symmetric2<double>& green,
                      const detail::Symmetric2<double>& rate) {
  if (m.kind == MembraneKind::isotropic)
    return {detail::membrane_stress(green, m.membrane), detail::membrane_stress(rate, m.membrane)};
  return {m.orthotropic.response(green, false).stress, m.orthotropic.response(rate, false).stress};
}

/// Bound of the largest eigenvalue of a triangle's stiffness at rest over the mass of a corner.
///   sqrt(tr((D G)^2)) area / corner mass,  D the law's tangent, G = sum of the strain rows'
///   products
double triangle_eigenvalue(const MaterialRow<double>& m, const Mat2<double>& inv_rest, double area,
                           double corner_mass) {
  double d[6];
  if (m.kind == MembraneKind::isotropic) {
    const auto& c = m.membrane;
    const double same = 2 * c.mu + c.lambda;
    const double rows[6] = {same, c.lambda, 0, same, 0, c.mu};
    std::copy(rows, rows + 6, d);
  } else {
    const MembraneResponse<double> r = m.orthotropic.response({0, 0, 0}, false);
    std::copy(r.tangent, r.tangent + 6, d);
  }
  const Mat3<double> tangent{{d[0], d[1], d[2], d[1], d[3], d[4], d[2], d[4], d[5]}};
  Mat3<double> gram{};
  for (int k = 0; k < 3; ++k) {
    const double bx = k == 0 ? -(inv_rest(0, 0) + inv_rest(1, 0)) : inv_rest(k - 1, 0);
    const double by = k == 0 ? -(inv_rest(0, 1) + inv_rest(1, 1)) : inv_rest(k - 1, 1);
    gram(0, 0) += bx * bx;
    gram(1, 1) += by * by;
    gram(2, 2) += bx * bx + by * by;
    gram(0, 2) += bx * by;
    gram(1, 2) += bx * by;
  }
  gram(2, 0) = gram(0, 2);
  gram(2, 1) = gram(1, 2);
  const Mat3<double> product = tangent * gram;
  double trace = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) trace += product(i, j) * product(j, i);
  return std::sqrt(trace) * area / corner_mass;
}

/// Square of the hinge angle's gradient, at the start: rest and start differ little in length.
double flat_slope_sq(const Model& model, const Hinge& hinge) {
  Vec3<double> x[4], slope[4];
  for (int c = 0; c < 4; ++c) x[c] = model.positions[at(hinge.v[c])];
  hinge_angle_gradient(x, slope);
  double sum = 0;
  for (const Vec3<double>& s : slope) sum += length_sq(s);
  return sum;
}

}  // namespace

Sheet::Sheet(const Model& model, const std::vector<Index>& place, const std::vector<Index>& order)
    : materials_(model.laws->rows) {
  const auto count = at(model.cloth_vertex_count);
  for (std::size_t i = 0; i < count; ++i) {
    mass_.push_back(model.mass[at(order[i])]);
    damping_mass_.push_back(model.damping_mass[at(order[i])]);
  }
  const auto triangle_count = at(model.cloth_triangle_count);
  std::vector<std::size_t> by_corner(triangle_count);
  std::iota(by_corner.begin(), by_corner.end(), std::size_t{0});
  const auto lowest = [&](std::size_t t) {
    const Index* v = model.triangles[t].v;
    return std::min({place[at(v[0])], place[at(v[1])], place[at(v[2])]});
  };
  std::stable_sort(by_corner.begin(), by_corner.end(),
                   [&](std::size_t a, std::size_t b) { return lowest(a) < lowest(b); });
  for (const std::size_t t : by_corner) {
    Tri tri = model.triangles[t];
    for (Index& v : tri.v) v = place[at(v)];
    triangles_.push_back(tri);
    inv_rest_.push_back(model.inv_rest[t]);
    area_.push_back(model.area[t]);
    material_.push_back(model.material[t]);
    damping_ = std::max(damping_, materials_.rows[at(model.material[t])].damping_stiffness);
  }
  for (std::size_t h = 0; h < model.hinges.size(); ++h) {
    Hinge hinge = model.hinges[h];
    for (Index& v : hinge.v) v = place[at(v)];
    hinges_.push_back(hinge);
  }
  for (const Hinge& hinge : model.hinges) hinge_slope_sq_.push_back(flat_slope_sq(model, hinge));
  hinge_stiffness_ = model.hinge_stiffness;
  hinge_rest_ = model.hinge_rest_angle;
  hinge_damping_ = model.hinge_damping;

  for (const Index m : material_)
    one_damping_ = one_damping_ && materials_.rows[at(m)].damping_stiffness == damping_;
  make_blocks();

  std::vector<Index> owner;
  for (const Tri& t : triangles_) owner.insert(owner.end(), t.v, t.v + 3);
  for (const Hinge& h : hinges_) owner.insert(owner.end(), h.v, h.v + 4);
  offset_.assign(count + 1, 0);
  for (const Index v : owner) ++offset_[at(v) + 1];
  std::partial_sum(offset_.begin(), offset_.end(), offset_.begin());
  corner_.resize(owner.size());
  std::vector<std::size_t> next(offset_.begin(), offset_.end() - 1);
  for (std::size_t c = 0; c < owner.size(); ++c)
    corner_[next[at(owner[c])]++] = static_cast<std::uint32_t>(c);
}

void Sheet::make_blocks() {
  constexpr std::size_t width = Simd::count;
  for (std::size_t first = 0; first < triangles_.size(); first += width) {
    TriangleBlock block;
    block.whole = first + width <= triangles_.size();
    for (int k = 0; k < Simd::count; ++k) {
      const std::size_t t = std::min(first + static_cast<std::size_t>(k), triangles_.size() - 1);
      const MaterialRow<double>& m = materials_.rows[at(material_[t])];
      block.whole = block.whole && m.kind == MembraneKind::isotropic;
      block.v[k] = triangles_[t];
      for (int e = 0; e < 4; ++e) block.inv_rest.e[e].set(k, inv_rest_[t].e[e]);
      block.area.set(k, area_[t]);
      block.membrane.lambda.set(k, m.membrane.lambda);
      block.membrane.mu.set(k, m.membrane.mu);
      block.damping.set(k, m.damping_stiffness);
      block.damped = block.damped || m.damping_stiffness > 0;
    }
    blocks_.push_back(block);
  }
}

void Sheet::triangle_gradient(std::size_t t, const VertexMotion& motion,
                              Vec3<double> (&g)[3]) const {
  const Tri& tri = triangles_[t];
  const MaterialRow<double>& m = materials_.rows[at(material_[t])];
  const Mat2<double>& inv = inv_rest_[t];
  Vec3<double> x[3], v[3];
  for (int c = 0; c < 3; ++c) {
    x[c] = motion.x[at(tri.v[c])];
    v[c] = motion.v[at(tri.v[c])];
  }
  const auto strain = detail::membrane_strain(x, inv);
  const Vec3<double> d1 = v[1] - v[0], d2 = v[2] - v[0];
  const Vec3<double> r0 = d1 * inv(0, 0) + d2 * inv(1, 0);
  const Vec3<double> r1 = d1 * inv(0, 1) + d2 * inv(1, 1);
  const detail::Symmetric2<double> rate{
      dot(strain.f0, r0), 0.5 * (dot(strain.f0, r1) + dot(strain.f1, r0)), dot(strain.f1, r1)};
  const StressAndRate s = respond(m, strain.green, rate);
  const double b = m.damping_stiffness;
  detail::membrane_forces(
      strain,
      {s.stress.xx + b * s.rate.xx, s.stress.xy + b * s.rate.xy, s.stress.yy + b * s.rate.yy}, inv,
      area_[t], g);
}

void Sheet::hinge_gradient(std::size_t h, const VertexMotion& motion, Vec3<double> (&g)[4]) const {
  const Hinge& hinge = hinges_[h];
  Vec3<double> x[4];
  for (int c = 0; c < 4; ++c) x[c] = motion.x[at(hinge.v[c])];
  const double theta = hinge_angle_gradient(x, g);
  double slope = theta - hinge_rest_[h];
  if (hinge_damping_[h] > 0) {
    double rate = 0;
    for (int c = 0; c < 4; ++c) rate += dot(g[c], motion.v[at(hinge.v[c])]);
    slope += hinge_damping_[h] * rate;
  }
  for (int c = 0; c < 4; ++c) g[c] *= 2 * hinge_stiffness_[h] * slope;
}

template <class To>
void Sheet::gradients(std::size_t first, std::size_t last, const VertexMotion& motion,
                      const To& to) const {
  constexpr std::size_t width = Simd::count;
  BlockGradient g;
  Vec3<double> of_hinge[4];
  for (std::size_t n = first; n < last; ++n) {
    if (n >= blocks_.size()) {
      const std::size_t h = n - blocks_.size();
      hinge_gradient(h, motion, of_hinge);
      for (std::size_t c = 0; c < 4; ++c)
        to(3 * triangles_.size() + 4 * h + c, at(hinges_[h].v[c]), of_hinge[c]);
      continue;
    }
    const std::size_t count = std::min(width, triangles_.size() - width * n);
    if (blocks_[n].whole)
      block_gradient(blocks_[n], motion, g);
    else
      for (std::size_t k = 0; k < count; ++k) triangle_gradient(width * n + k, motion, g[k]);
    for (std::size_t k = 0; k < count; ++k)
      for (std::size_t c = 0; c < 3; ++c)
        to(3 * (width * n + k) + c, at(blocks_[n].v[k].v[c]), g[k][c]);
  }
}

/// Positions, and what damping adds to them, as the plate reads them: before any vertex is kicked.
void Sheet::pack(const VertexMotion& motion, Workers& workers) {
  const double b = one_damping_ ? damping_ : 0;
  point_.resize(mass_.size());
  if (!one_damping_) rate_.resize(mass_.size());
  workers.share(mass_.size(), points_a_thread, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      const Vec3<double>& x = motion.x[i];
      const Vec3<double>& v = motion.v[i];
      point_[i] = Simd(Simd::Pack{x[0] + b * v[0], x[1] + b * v[1], x[2] + b * v[2], 0});
      if (!one_damping_) rate_[i] = Simd(Simd::Pack{v[0], v[1], v[2], 0});
    }
  });
}

/// Rows sum to zero: differences say the same more exactly.
Vec3<double> Sheet::plate_gradient(std::size_t i, const PlateMatrix& plate) const {
  Simd g(0);
  const auto begin = static_cast<std::size_t>(plate.row_offset[i]);
  const auto end = static_cast<std::size_t>(plate.row_offset[i + 1]);
  for (std::size_t e = begin; e < end; ++e)
    g += (point_[at(plate.column[e])] - point_[i]) * Simd(plate.stiffness[e]);
  if (!one_damping_)
    for (std::size_t e = begin; e < end; ++e)
      g += (rate_[at(plate.column[e])] - rate_[i]) * Simd(plate.damping[e]);
  return {g[0], g[1], g[2]};
}

void Sheet::kick(double h, const PlateMatrix& plate, VertexMotion& motion, Workers& workers) {
  const bool bends = !plate.row_offset.empty();
  if (bends) pack(motion, workers);
  const bool stored = workers.parts_of(item_count(), elements_a_thread) > 1;
  if (stored) {
    share_.resize(corner_.size());
    workers.share(item_count(), elements_a_thread, [&](std::size_t a, std::size_t b) {
      gradients(a, b, motion, [&](std::size_t corner, std::size_t, const Vec3<double>& g) {
        share_[corner] = g;
      });
    });
  } else {
    gradient_.assign(mass_.size(), {});
    gradients(0, item_count(), motion,
              [&](std::size_t, std::size_t v, const Vec3<double>& g) { gradient_[v] += g; });
  }
  const auto gradient_of = [&](std::size_t i) {
    Vec3<double> gradient{};
    if (stored)
      for (std::size_t c = offset_[i]; c < offset_[i + 1]; ++c) gradient += share_[corner_[c]];
    else
      gradient = gradient_[i];
    if (bends) gradient += plate_gradient(i, plate);
    return gradient;
  };
  workers.share(mass_.size(), sums_a_thread, [&](std::size_t a, std::size_t b) {
    for (std::size_t i = a; i < b; ++i)
      if (motion.inv_mass[i] > 0)
        motion.v[i] -=
            gradient_of(i) * (h * motion.inv_mass[i]) + motion.v[i] * (h * damping_mass_[i]);
  });
  for (std::size_t i = 0; i < mass_.size() && !motion.carrier.empty(); ++i)
    if (motion.inv_mass[i] == 0) motion.push_carrier(i, motion.t[i], gradient_of(i) * -h);
}

double Sheet::membrane_eigenvalue() const {
  double most = 0;
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    // Each corner brings what part of its mass the triangle gave it, or more.
    double corner = std::numeric_limits<double>::infinity();
    for (const Index v : triangles_[t].v) {
      double area = 0;
      for (std::size_t c = offset_[at(v)]; c < offset_[at(v) + 1]; ++c)
        if (corner_[c] < 3 * triangles_.size()) area += area_[corner_[c] / 3];
      corner = std::min(corner, mass_[at(v)] * area_[t] / area);
    }
    most = std::max(most, triangle_eigenvalue(materials_.rows[at(material_[t])], inv_rest_[t],
                                              area_[t], corner));
  }
  return most;
}

/// Gauss-Newton: 2 c grad theta grad theta^T has one eigenvalue.
double Sheet::hinge_eigenvalue() const {
  std::vector<int> hinges_of(mass_.size(), 0);
  for (const Hinge& h : hinges_)
    for (const Index v : h.v) ++hinges_of[at(v)];
  double most = 0;
  for (std::size_t h = 0; h < hinges_.size(); ++h) {
    double inverse = 0;
    for (const Index v : hinges_[h].v) inverse = std::max(inverse, hinges_of[at(v)] / mass_[at(v)]);
    most = std::max(most, 2 * hinge_stiffness_[h] * hinge_slope_sq_[h] * inverse);
  }
  return most;
}

double Sheet::plate_eigenvalue(const PlateMatrix& plate) const {
  double most = 0;
  for (std::size_t i = 0; i + 1 < plate.row_offset.size(); ++i) {
    double row = 0;
    for (auto e = static_cast<std::size_t>(plate.row_offset[i]);
         e < static_cast<std::size_t>(plate.row_offset[i + 1]); ++e)
      row += std::abs(plate.stiffness[e]) / std::sqrt(mass_[i] * mass_[at(plate.column[e])]);
    most = std::max(most, row);
  }
  return most;
}

double Sheet::stable_step(const PlateMatrix& plate) const {
  const double omega =
      std::sqrt(membrane_eigenvalue() + hinge_eigenvalue() + plate_eigenvalue(plate));
  const double z = damping_ * omega / 2;
  return 1 / (omega * (std::sqrt(1 + z * z) + z));
}

PlateMatrix renumbered(const PlateMatrix& plate, const std::vector<Index>& place,
                       const std::vector<Index>& order) {
  PlateMatrix out;
  if (plate.row_offset.empty()) return out;
  out.row_offset.push_back(0);
  std::vector<std::pair<Index, std::size_t>> row;
  for (std::size_t i = 0; i + 1 < plate.row_offset.size(); ++i) {
    const auto from = at(order[i]);
    row.clear();
    for (auto e = static_cast<std::size_t>(plate.row_offset[from]);
         e < static_cast<std::size_t>(plate.row_offset[from + 1]); ++e)
      row.emplace_back(place[at(plate.column[e])], e);
    std::sort(row.begin(), row.end());
    for (const auto& [column, e] : row) {
      out.column.push_back(column);
      out.stiffness.push_back(plate.stiffness[e]);
      out.damping.push_back(plate.damping[e]);
    }
    out.row_offset.push_back(static_cast<Offset>(out.column.size()));
  }
  return out;
}

}  // namespace weft
