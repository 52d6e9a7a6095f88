#include "weft/kernels/assemble/contact_cache.hpp"

#include "tests/parity/assemble/contact_set.hpp"

namespace weft::parity {
namespace {

template <class T>
struct ContactCacheCase {
  using Scalar = T;
  ContactSet<T> set{19, 500};

  ContactCacheCase() {
    for (std::size_t n = 0; n < set.contacts.size(); ++n)
      set.contacts[n].pair = {static_cast<Index>(n), static_cast<Index>(3 * n)};
  }

  Outputs compute(Device& device, Index parts) const {
    const auto contacts_d = upload(device, set.contacts);
    const auto x = upload(device, set.positions), x0 = upload(device, set.positions_t0);
    const Buffer<ContactMemory<T>> memory(device, set.contacts.size());
    for (const auto& [begin, size] : parts_of(static_cast<Index>(set.contacts.size()), parts)) {
      const auto b = static_cast<std::size_t>(begin), n = static_cast<std::size_t>(size);
      launch(device.compute(), AssembleContactCache<T>{contacts_d.span().subspan(b, n), x.span(),
                                                       x0.span(), memory.span().subspan(b, n)});
    }
    return numbers(download(memory));
  }
  template <class U>
  static Outputs numbers(const std::vector<ContactMemory<U>>& all) {
    std::vector<double> pair, force, displacement;
    std::vector<Vec3<U>> anchor, n;
    for (const ContactMemory<U>& m : all) {
      pair.insert(pair.end(), {double(m.pair.a), double(m.pair.b)});
      force.push_back(double{m.normal_force});
      displacement.push_back(double{m.displacement});
      anchor.push_back(m.anchor);
      n.push_back(m.n);
    }
    return {{"pair", pair},
            {"normal force", force},
            {"displacement", displacement},
            output("anchor", anchor),
            output("normal", n)};
  }

  Outputs reference() const {
    const std::vector<Vec3<double>> x = in_double(set.positions), x0 = in_double(set.positions_t0);
    std::vector<ContactMemory<double>> all;
    for (const Contact<T>& contact : set.contacts) {
      const Contact<double> c = in_double(contact);
      double gap = 0;
      Vec3<double> slip{};
      for (int j = 0; j < 4; ++j) {
        const auto v = static_cast<std::size_t>(c.v[j]);
        gap += c.w[j] * dot(c.n, x[v]);
        slip += c.w[j] * (x[v] - x0[v]);
      }
      const Vec3<double> u = c.anchor + slip - dot(slip, c.n) * c.n;
      const double force = std::max(0.0, c.stiffness * (c.thickness - gap));
      // The anchor slides until friction is within Coulomb's limit.
      const double reach = c.friction * force / c.stiffness;
      const Vec3<double> anchor = length(u) > reach ? (reach / length(u)) * u : u;
      all.push_back({c.pair, force, length(u), anchor, c.n});
    }
    return numbers(all);
  }
};

using Cases = testing::Types<ContactCacheCase<float>, ContactCacheCase<double>>;
INSTANTIATE_TYPED_TEST_SUITE_P(AssembleContactCache, KernelParity, Cases);

}  // namespace
}  // namespace weft::parity
