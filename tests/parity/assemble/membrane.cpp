#include "weft/kernels/assemble/membrane.hpp"

#include "host/scene/fabric/measured.hpp"
#include "tests/parity/assemble/turned_triangle.hpp"
#include "tests/parity/support.hpp"

namespace weft::parity {
namespace {

/// A law with limits, as a law.
template <class Law>
struct Limited {
  const Law& law;
  MembraneLimits<double> limits;

  double energy(const detail::Symmetric2<double>& g) const {
    return law.energy(g) + limits.energy(g);
  }
  MembraneResponse<double> response(const detail::Symmetric2<double>& g, bool project) const {
    MembraneResponse<double> sum = law.response(g, project);
    const MembraneResponse<double> more = limits.response(g, project);
    sum.stress.xx += more.stress.xx;
    sum.stress.xy += more.stress.xy;
    sum.stress.yy += more.stress.yy;
    for (int k = 0; k < 6; ++k) sum.tangent[k] += more.tangent[k];
    return sum;
  }
};

/// A crumpled sheet of one material of each kind, some of them damped, under way.
/// @tparam yields some triangles resist but a share of compression
/// @tparam turns  triangles turn before
template <class T, bool with_velocities, bool yields = false, bool turns = false>
struct MembraneCase {
  using Scalar = T;
  Random random{8};
  Sheet<T> sheet{random};
  std::size_t count = sheet.triangles.size();
  std::vector<Mat2<T>> inv_rest;
  std::vector<T> area;
  std::vector<Index> material;
  std::vector<T> compression;
  static constexpr Index sample_count = MembraneSamples<T>::value_count;
  std::vector<MaterialRow<T>> materials = {
      {{T(400), T(300)}, T(0), MembraneKind::isotropic, {T(1000), T(400), T(1000), T(600)}},
      {{T(250), T(350)}, T(0.0078125), MembraneKind::isotropic, {T(950), T(250), T(950), T(700)}},
      {{}, T(0.0078125), MembraneKind::orthotropic, {T(500), T(90), T(200), T(80)}},
      {{}, T(0), MembraneKind::samples, {}, 0},
      {{}, T(0.0078125), MembraneKind::ridges, {}, sample_count},
      {{}, T(0), MembraneKind::orthotropic, {T(500), T(90), T(200), T(80)}, 0, limits<T>()},
      {{}, T(0.0078125), MembraneKind::samples, {}, 0, limits<T>()},
      {{}, T(0), MembraneKind::ridges, {}, sample_count, limits<T>()}};
  std::vector<T> tables = measured_tables();
  std::vector<double> values{tables.begin(), tables.end()};
  std::vector<Vec3<T>> velocities =
      with_velocities ? random.vectors<T>(sheet.positions.size(), -1, 1) : std::vector<Vec3<T>>{};
  T h = T(0.0078125);

  std::vector<Vec3<T>> start_velocities =
      turns ? random.vectors<T>(sheet.positions.size(), -2, 2) : std::vector<Vec3<T>>{};
  T dt = T(0.0078125);

  MembraneCase() {
    for (MaterialRow<T>& m : materials) m.density = T(0.25);
    for (std::size_t n = 0; n < count; ++n) {
      // Edges at rest: the grid's, somewhat off. Rows of the inverse in closed form.
      const bool first = n % 2 == 0;
      const double e1[2] = {random.uniform<double>(0.09, 0.11), first ? 0.0 : 0.1};
      const double e2[2] = {first ? 0.1 : 0.0, random.uniform<double>(0.09, 0.11)};
      const double det = e1[0] * e2[1] - e1[1] * e2[0];
      inv_rest.push_back({{static_cast<T>(static_cast<float>(e2[1] / det)),
                           static_cast<T>(static_cast<float>(-e2[0] / det)),
                           static_cast<T>(static_cast<float>(-e1[1] / det)),
                           static_cast<T>(static_cast<float>(e1[0] / det))}});
      area.push_back(random.uniform<T>(0.004, 0.006));
      material.push_back(static_cast<Index>(n % materials.size()));
      constexpr T shares[] = {T(1), T(0.25), T(0)};
      if (yields) compression.push_back(shares[n % 3]);
    }
  }

  /// Within what the random sheet is strained by.
  template <class U>
  static MembraneLimits<U> limits() {
    return membrane_limits(U(0.9375), U(1.0625), U(4096));
  }

  /// Samples, then ridges.
  static std::vector<T> measured_tables() {
    MeasuredStretch measured;
    Random random{9};
    for (auto& row : measured.rows)
      for (double& c : row) c = random.uniform<double>(10, 300);
    std::vector<double> all = sample_measured(measured);
    const std::vector<double> ridges = fit_measured(measured).values;
    all.insert(all.end(), ridges.begin(), ridges.end());
    std::vector<T> tables;
    for (const double value : all) tables.push_back(static_cast<T>(value));
    return tables;
  }

  Outputs compute(Device& device, Index parts) const {
    const auto triangles_d = upload(device, sheet.triangles);
    const auto inv_rest_d = upload(device, inv_rest);
    const auto area_d = upload(device, area);
    const auto material_d = upload(device, material);
    const auto materials_d = upload(device, materials);
    const auto tables_d = upload(device, tables);
    const auto compression_d = upload(device, compression);
    const auto x = upload(device, sheet.positions), v = upload(device, velocities);
    const auto start = upload(device, start_velocities);
    const Buffer<Vec3<T>> impulse(device, 3 * count);
    const Buffer<Mat3<T>> block(device, 6 * count);
    for (const auto& [begin, size] : parts_of(static_cast<Index>(count), parts)) {
      const auto b = static_cast<std::size_t>(begin), n = static_cast<std::size_t>(size);
      launch(device.compute(),
             AssembleMembrane<T>{
                 triangles_d.span().subspan(b, n), inv_rest_d.span().subspan(b, n),
                 area_d.span().subspan(b, n), material_d.span().subspan(b, n), materials_d.span(),
                 x.span(), v.span(), h, impulse.span().subspan(3 * b, 3 * n),
                 block.span().subspan(6 * b, 6 * n), tables_d.span(),
                 compression.empty() ? compression_d.span() : compression_d.span().subspan(b, n),
                 turns ? TurnedStart<T>{x.span(), start.span(), dt} : TurnedStart<T>{}});
    }
    return {output("impulse", download(impulse)), output("block", download(block))};
  }

  /// Gradient and Hessian one by one; damping by the whole 9 x 9 matrix.
  Outputs reference() const {
    std::vector<Vec3<double>> impulse;
    std::vector<Mat3<double>> block;
    for (std::size_t n = 0; n < count; ++n) {
      const MaterialRow<T>& m = materials[static_cast<std::size_t>(material[n])];
      Vec3<double> x[3], g[3];
      Mat2<double> inverse{};
      for (int k = 0; k < 4; ++k) inverse.e[k] = double{inv_rest[n].e[k]};
      for (int c = 0; c < 3; ++c) x[c] = vec_cast<double>(sheet.positions[corner(n, c)]);
      const Vec3<double> iterate[] = {x[0], x[1], x[2]};
      if (turns) turn(n, inverse, x);
      Mat3<double> k[6];
      with_law(m, yields && compression[n] < T(1), [&](const auto& law) {
        using Law = std::decay_t<decltype(law)>;
        if constexpr (std::is_same_v<Law, MembraneConstants<double>>) {
          membrane_gradient(x, inverse, double{area[n]}, law, g);
          membrane_hessian(x, inverse, double{area[n]}, law, true, k);
        } else {
          const Limited<Law> limited{law,
                                     m.limits.any() ? limits<double>() : MembraneLimits<double>{}};
          const BuckledLaw<double, Limited<Law>> buckled{limited,
                                                         yields ? double{compression[n]} : 1.0};
          membrane_law_gradient(x, inverse, double{area[n]}, buckled, g);
          membrane_law_hessian(x, inverse, double{area[n]}, buckled, true, k);
        }
      });
      const double damping = double{m.damping_stiffness};
      constexpr int place[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
      for (int i = 0; i < 3; ++i) {
        Vec3<double> force = -g[i];
        for (int j = 0; with_velocities && j < 3; ++j) {
          const Mat3<double>& b = k[place[i][j]];
          force -=
              damping * ((i <= j ? b : transpose(b)) * vec_cast<double>(velocities[corner(n, j)]));
        }
        // Linear about where it is turned to; strain rates count from there, too.
        for (int j = 0; turns && j < 3; ++j) {
          const Mat3<double>& b = k[place[i][j]];
          const double share = with_velocities ? 1 : 1 + damping / double{h};
          force -= share * ((i <= j ? b : transpose(b)) * (iterate[j] - x[j]));
        }
        impulse.push_back(double{h} * force);
      }
      for (const Mat3<double>& b : k) block.push_back(double{h} * (double{h} + damping) * b);
    }
    return {output("impulse", impulse), output("block", block)};
  }
  /// Turns a triangle about its first corner.
  void turn(std::size_t n, const Mat2<double>& inverse, Vec3<double> x[3]) const {
    Eigen::Matrix2d rest;
    TriangleColumns edges, moved;
    double speed_sq = length_sq(vec_cast<double>(start_velocities[corner(n, 0)]));
    for (int k = 0; k < 2; ++k) {
      const auto v = vec_cast<double>(start_velocities[corner(n, k + 1)]);
      speed_sq += length_sq(v);
      const Vec3<double> edge = x[k + 1] - x[0];
      const Vec3<double> rate = v - vec_cast<double>(start_velocities[corner(n, 0)]);
      for (int c = 0; c < 3; ++c) {
        edges(c, k) = edge[c];
        moved(c, k) = double{dt} * rate[c];
      }
      for (int c = 0; c < 2; ++c) rest(c, k) = inverse(c, k);
    }
    const MaterialRow<T>& m = materials[static_cast<std::size_t>(material[n])];
    const double stiffness = m.kind == MembraneKind::orthotropic
                                 ? std::max(double{m.orthotropic.c11}, double{m.orthotropic.c22})
                                 : double{m.membrane.lambda} + 2 * double{m.membrane.mu};
    const TriangleColumns turned =
        turned_columns(edges * rest, moved * rest, 0.03 * 0.25 / 6 * speed_sq, stiffness / 8) *
        rest.inverse();
    for (int k = 0; k < 2; ++k)
      x[k + 1] = x[0] + Vec3<double>{turned(0, k), turned(1, k), turned(2, k)};
  }
  /// Calls visit with the law of a material, in double.
  /// @param general isotropic ones as orthotropic ones
  template <class Visit>
  void with_law(const MaterialRow<T>& m, bool general, const Visit& visit) const {
    const auto& c = m.orthotropic;
    switch (general && m.kind == MembraneKind::isotropic ? MembraneKind::orthotropic : m.kind) {
      case MembraneKind::isotropic:
        return visit(MembraneConstants<double>{double{m.membrane.lambda}, double{m.membrane.mu}});
      case MembraneKind::orthotropic:
        return visit(OrthotropicMembrane<double>{double{c.c11}, double{c.c12}, double{c.c22},
                                                 double{c.c33}});
      case MembraneKind::samples:
        return visit(MembraneSamples<double>{values.data() + m.table});
      case MembraneKind::ridges:
        return visit(MembraneRidges<double>{values.data() + m.table});
    }
  }
  std::size_t corner(std::size_t n, int c) const {
    return static_cast<std::size_t>(sheet.triangles[n].v[c]);
  }
};

using Cases = testing::Types<
    MembraneCase<float, true>, MembraneCase<float, false>, MembraneCase<double, true>,
    MembraneCase<double, false>, MembraneCase<float, true, true>, MembraneCase<double, true, true>,
    MembraneCase<float, true, false, true>, MembraneCase<double, false, false, true>>;
INSTANTIATE_TYPED_TEST_SUITE_P(AssembleMembrane, KernelParity, Cases);

}  // namespace
}  // namespace weft::parity
