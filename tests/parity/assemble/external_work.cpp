#include "weft/kernels/assemble/external_work.hpp"

#include "tests/parity/assemble/contact_set.hpp"

namespace weft::parity {
namespace {

/// Contacts of a crowd and a sheet in the wind, beside each other; forces act on all vertices, and
/// some are held.
template <class T, bool pressed, Index partial_items>
struct ExternalWorkCase {
  using Scalar = T;
  ContactSet<T> set{23, 700};
  Random random{24};
  Sheet<T> sheet{random};
  std::vector<T> pressure =
      pressed ? random.numbers<T>(sheet.triangles.size(), -50, 50) : std::vector<T>{};
  std::vector<Vec3<T>> x0, x1, v0, v1;
  std::vector<unsigned char> fixed;
  std::vector<Vec3<T>> accelerations;
  std::vector<T> mass;
  Vec3<T> wind{T(3), T(-1), T(0.5)};
  T density = T(1.25), drag = T(0.0625);

  ExternalWorkCase() {
    sheet.triangles[7].v[1] = sheet.triangles[7].v[0];
    x0 = set.positions_t0;
    x1 = set.positions;
    const auto first = static_cast<Index>(x0.size());
    for (const Vec3<T>& x : sheet.positions) {
      x0.push_back(x);
      x1.push_back(x + random.vector<T>(-0.03125, 0.03125));
    }
    for (Tri& t : sheet.triangles)
      for (Index& v : t.v) v += first;
    v0 = random.vectors<T>(x0.size(), -2, 2);
    v1 = random.vectors<T>(x0.size(), -2, 2);
    fixed = random.marks(x0.size(), 5);
    accelerations = random.vectors<T>(x0.size(), -20, 20);
    mass = random.numbers<T>(x0.size(), 0.001, 0.01);
    for (std::size_t v = ContactSet<T>::cloth; v < ContactSet<T>::vertices; ++v) fixed[v] = 1;
  }

  /// The same partial sums, whoever computes them.
  Outputs compute(Device& device, Index) const {
    const auto contacts_d = upload(device, set.contacts);
    const auto triangles_d = upload(device, sheet.triangles);
    const auto pressure_d = upload(device, pressure);
    const auto fixed_d = upload(device, fixed);
    const auto x0_d = upload(device, x0), x1_d = upload(device, x1);
    const auto v0_d = upload(device, v0), v1_d = upload(device, v1);
    const auto accelerations_d = upload(device, accelerations);
    const auto mass_d = upload(device, mass);
    AssembleExternalWork<T> args{contacts_d.span(),
                                 triangles_d.span(),
                                 pressure_d.span(),
                                 fixed_d.span(),
                                 x0_d.span(),
                                 x1_d.span(),
                                 v0_d.span(),
                                 v1_d.span(),
                                 density,
                                 drag,
                                 wind,
                                 accelerations_d.span(),
                                 mass_d.span(),
                                 partial_items};
    const Buffer<double> partial(device, static_cast<std::size_t>(args.partials()));
    args.partial = partial.span();
    launch(device.compute(), args);
    return {output("partial", download(partial))};
  }

  double at_contact(const Contact<T>& contact) const {
    const Contact<double> c = in_double(contact);
    double gap = 0;
    Vec3<double> slip{}, held{};
    for (int j = 0; j < 4; ++j) {
      const auto v = static_cast<std::size_t>(c.v[j]);
      const Vec3<double> moved = vec_cast<double>(x1[v]) - vec_cast<double>(x0[v]);
      gap += c.w[j] * dot(c.n, vec_cast<double>(x1[v]));
      slip += c.w[j] * moved;
      if (fixed[v] != 0) held += c.w[j] * moved;
    }
    const Vec3<double> u = c.anchor + slip - dot(slip, c.n) * c.n;
    const double normal = std::max(0.0, c.stiffness * (c.thickness - gap));
    const double sliding = c.friction * normal;
    const double rub = std::min(c.hold * length(u), sliding);
    const Vec3<double> force =
        normal * c.n - (length(u) > 0 ? (rub / length(u)) * u : Vec3<double>{});
    return -dot(force, held);
  }

  /// Pressure by Gauss's rule along the way, wind as in the test of AssembleWind.
  double at_triangle(std::size_t t) const {
    const auto corner = [&](const std::vector<Vec3<T>>& all, int c) {
      return vec_cast<double>(all[static_cast<std::size_t>(sheet.triangles[t].v[c])]);
    };
    const auto area = [&](double s) {
      const auto x = [&](int c) { return corner(x0, c) + s * (corner(x1, c) - corner(x0, c)); };
      return 0.5 * cross(x(1) - x(0), x(2) - x(0));
    };
    Vec3<double> free{}, mean_start{}, mean_end{};
    for (int c = 0; c < 3; ++c) {
      if (fixed[static_cast<std::size_t>(sheet.triangles[t].v[c])] == 0)
        free += corner(x1, c) - corner(x0, c);
      mean_start += (1.0 / 3) * corner(v0, c);
      mean_end += (1.0 / 3) * corner(v1, c);
    }
    double work = 0;
    const double aside = std::sqrt(1.0 / 12);
    if (pressed) work += double{pressure[t]} / 6 * dot(area(0.5 - aside) + area(0.5 + aside), free);
    const double size = length(area(0));
    if (!(size > 0)) return work;
    const Vec3<double> n = (1 / size) * area(0), air = vec_cast<double>(wind);
    const Vec3<double> u = air - mean_end, along = dot(u, n) * n;
    const double push = double{density} * std::abs(dot(air - mean_start, n));
    return work + size / 3 * dot(push * along + double{drag} * (u - along), free);
  }

  double at_vertex(std::size_t v) const {
    if (fixed[v] != 0) return 0;
    double work = 0;
    for (int c = 0; c < 3; ++c)
      work += double{mass[v]} * double{accelerations[v][c]} * (double{x1[v][c]} - double{x0[v][c]});
    return work;
  }

  Outputs reference() const {
    const std::size_t others = set.contacts.size() + sheet.triangles.size();
    const std::size_t count = others + x0.size();
    std::vector<double> partial((count + partial_items - 1) / partial_items, 0);
    for (std::size_t i = 0; i < count; ++i)
      partial[i / partial_items] += i < set.contacts.size() ? at_contact(set.contacts[i])
                                    : i < others            ? at_triangle(i - set.contacts.size())
                                                            : at_vertex(i - others);
    return {output("partial", partial)};
  }
};

using Cases =
    testing::Types<ExternalWorkCase<float, true, 1024>, ExternalWorkCase<float, false, 64>,
                   ExternalWorkCase<double, true, 8>, ExternalWorkCase<double, false, 256>>;
INSTANTIATE_TYPED_TEST_SUITE_P(AssembleExternalWork, KernelParity, Cases);

}  // namespace
}  // namespace weft::parity
