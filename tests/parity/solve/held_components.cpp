#include "weft/kernels/solve/held_components.hpp"

#include "tests/parity/support.hpp"

namespace weft::parity {
namespace {

/// 400 vertices of cloth in 40 components, and 50 of obstacles. Contacts of components with
/// themselves, with each other, with obstacles; some components have none, some are held already.
template <class T>
struct HeldComponentsCase {
  using Scalar = T;
  static constexpr Index cloth = 400, all = 450, components = 40, contact_count = 60;
  Random random{15};
  std::vector<Index> component_of_vertex;
  std::vector<Contact<T>> contacts{contact_count};
  std::vector<Index> held = std::vector<Index>(components, 0);

  HeldComponentsCase() {
    for (Index v = 0; v < cloth; ++v) component_of_vertex.push_back(v * 7 % components);
    for (std::size_t n = 0; n < contacts.size(); ++n) {
      Contact<T>& c = contacts[n];
      for (Index& v : c.v)
        v = static_cast<Index>(random.uniform<double>(0, 1) * double(n < 20 ? all - 1 : cloth - 1));
      // Components of vertices 40 apart are the same.
      if (n >= 20) c.v[3] = (c.v[0] + 40) % cloth;
    }
    held[3] = held[17] = 1;
  }

  Outputs compute(Device& device, Index parts) const {
    const auto contacts_d = upload(device, contacts);
    const auto component_d = upload(device, component_of_vertex);
    const auto held_d = upload(device, held);
    for (const auto& [begin, size] : parts_of(contact_count, parts))
      launch(device.compute(),
             SolveHeldComponents<T>{contacts_d.span().subspan(static_cast<std::size_t>(begin),
                                                              static_cast<std::size_t>(size)),
                                    component_d.span(), held_d.span()});
    return {output("held", download(held_d))};
  }

  Outputs reference() const {
    std::vector<Index> result = held;
    const auto component = [&](Index v) {
      return v < cloth ? component_of_vertex[static_cast<std::size_t>(v)] : -1;
    };
    for (const Contact<T>& c : contacts)
      for (const Index v : {c.v[0], c.v[3]})
        if (component(c.v[0]) != component(c.v[3]) && component(v) >= 0)
          result[static_cast<std::size_t>(component(v))] = 1;
    EXPECT_EQ(std::count(result.begin(), result.end(), 0) > 5, true);
    EXPECT_EQ(std::count(result.begin(), result.end(), 1) > 5, true);
    return {output("held", result)};
  }
};

using Cases = testing::Types<HeldComponentsCase<float>, HeldComponentsCase<double>>;
INSTANTIATE_TYPED_TEST_SUITE_P(SolveHeldComponents, KernelParity, Cases);

}  // namespace
}  // namespace weft::parity
