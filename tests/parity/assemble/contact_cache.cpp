#include "weft/kernels/assemble/contact_cache.hpp"

#include "tests/parity/assemble/contact_set.hpp"

namespace weft::parity {
namespace {

template <class T>
struct ContactCacheCase {
  using Scalar = T;
  static constexpr double load_share = 0.3;
  ContactSet<T> set{19, 500};

  ContactCacheCase() {
    for (std::size_t n = 0; n < set.contacts.size(); ++n)
      set.contacts[n].pair = {static_cast<Index>(n), static_cast<Index>(3 * n)};
  }

  Outputs compute(Device& device, Index parts) const {
    const auto contacts_d = upload(device, set.contacts);
    const auto x = upload(device, set.positions), x0 = upload(device, set.positions_t0);
    const Buffer<ContactMemory<T>> memory(device, set.contacts.size());
    const std::vector<unsigned char> none(static_cast<std::size_t>(set.cloth), 0);
    const auto touched = upload(device, levels(set.cloth));
    const auto crushed = upload(device, none), in_jam = upload(device, none);
    for (const auto& [begin, size] : parts_of(static_cast<Index>(set.contacts.size()), parts)) {
      const auto b = static_cast<std::size_t>(begin), n = static_cast<std::size_t>(size);
      launch(device.compute(),
             AssembleContactCache<T>{contacts_d.span().subspan(b, n), x.span(), x0.span(),
                                     static_cast<T>(load_share), memory.span().subspan(b, n),
                                     touched.span(), crushed.span(), in_jam.span()});
    }
    return numbers(download(memory), download(crushed), download(in_jam));
  }
  template <class U>
  static Outputs numbers(const std::vector<ContactMemory<U>>& all,
                         const std::vector<unsigned char>& crushed,
                         const std::vector<unsigned char>& crushed_in_jam) {
    std::vector<double> pair, force, load, sticking;
    std::vector<Vec3<U>> friction, n;
    for (const ContactMemory<U>& m : all) {
      pair.insert(pair.end(), {double(m.pair.a), double(m.pair.b)});
      force.push_back(double{m.normal_force});
      load.push_back(double{m.load});
      sticking.push_back(double{m.sticking_force});
      friction.push_back(m.friction);
      n.push_back(m.n);
    }
    return {{"pair", pair},
            {"normal force", force},
            {"mean load", load},
            {"force to stick", sticking},
            output("friction", friction),
            output("crushed", crushed),
            output("crushed in a jam", crushed_in_jam),
            output("normal", n)};
  }

  Outputs reference() const {
    const std::vector<Vec3<double>> x = in_double(set.positions), x0 = in_double(set.positions_t0);
    std::vector<ContactMemory<double>> all;
    std::vector<unsigned char> crushed(static_cast<std::size_t>(set.cloth), 0), in_jam = crushed;
    for (const Contact<T>& contact : set.contacts) {
      const Contact<double> c = in_double(contact);
      double gap = 0, gap_t0 = 0;
      Vec3<double> slip{};
      for (int j = 0; j < 4; ++j) {
        const auto v = static_cast<std::size_t>(c.v[j]);
        gap += c.w[j] * dot(c.n, x[v]);
        gap_t0 += c.w[j] * dot(c.n, x0[v]);
        slip += c.w[j] * (x[v] - x0[v]);
      }
      for (const Index v : c.v) {
        if (v >= set.cloth || !plainly_crushed(c, gap, gap_t0)) continue;
        crushed[static_cast<std::size_t>(v)] = 1;
        if (has_level(c, levels(set.cloth))) in_jam[static_cast<std::size_t>(v)] = 1;
      }
      const Vec3<double> u = c.anchor + slip - dot(slip, c.n) * c.n;
      const double force = std::max(0.0, c.stiffness * (c.thickness - gap));
      // The anchor slides until friction is within Coulomb's limit.
      const double limit = c.friction * force;
      const Vec3<double> sticking = c.hold * u;
      const Vec3<double> friction =
          length(sticking) > limit ? (limit / length(sticking)) * sticking : sticking;
      const double load = (1 - T(load_share)) * c.load + T(load_share) * force;
      all.push_back({c.pair, force, load, length(sticking), friction, c.n});
    }
    return numbers(all, crushed, in_jam);
  }
};

using Cases = testing::Types<ContactCacheCase<float>, ContactCacheCase<double>>;
INSTANTIATE_TYPED_TEST_SUITE_P(AssembleContactCache, KernelParity, Cases);

}  // namespace
}  // namespace weft::parity
