#include "weft/kernels/solve/halo.hpp"

#include <set>

#include "tests/parity/solve/system.hpp"

namespace weft::parity {
namespace {

/// What rank 1 of 4 gets from the others, one of which has no rows; `parts` is how often the list
/// is made, with the same stamps.
template <class T, bool with_contact>
struct HaloCase {
  using Scalar = T;
  static constexpr Index vertices = 30'000, row_count = 8'000;
  std::vector<Index> row_begin{0, 9'000, 17'000, 17'000, vertices};
  Random random{16};
  std::vector<Index> mesh_ghost = some_others(900);
  /// Contacts of own vertices with any three.
  std::vector<ContactOperatorEntry<T>> links;

  HaloCase() {
    if (!with_contact) return;
    const auto any = [&](Index count) {
      return static_cast<Index>(random.uniform<double>(0, 1) * (count - 1));
    };
    for (int n = 0; n < 3'000; ++n)
      links.push_back(
          {{row_begin[1] + any(row_count), any(vertices), any(vertices), any(vertices)}, {}, {}});
  }
  std::vector<Index> some_others(std::size_t count) {
    std::set<Index> all;
    while (all.size() < count) {
      const auto v = static_cast<Index>(random.uniform<double>(0, 1) * (vertices - 1));
      if (v < row_begin[1] || v >= row_begin[2]) all.insert(v);
    }
    return {all.begin(), all.end()};
  }

  Outputs compute(Device& device, Index parts) const {
    const auto row_begin_d = upload(device, row_begin), mesh_ghost_d = upload(device, mesh_ghost);
    // Behind what there is comes capacity that nobody may read.
    std::vector<ContactOperatorEntry<T>> all = links;
    all.resize(links.size() + 100, {{-1, -1, -1, -1}, {}, {}});
    const auto link_d = upload(device, all);
    const auto count_d = upload(device, std::vector<Index>{static_cast<Index>(links.size())});
    ContactOperator<T> contact;
    if (with_contact) contact = {link_d.span(), count_d.span(), {}, {}, {}};
    const auto stamp = upload(device, std::vector<Index>(vertices, 0));
    const Buffer<Index> ghost(device, vertices), ghost_offset(device, row_begin.size());
    for (Index epoch = 1; epoch <= parts; ++epoch)
      launch(device.compute(),
             SolveHalo<T>{1, row_begin_d.span(), mesh_ghost_d.span(), contact, stamp.span(), epoch,
                          ghost.span(), ghost_offset.span()});
    const std::vector<Index> offsets = download(ghost_offset);
    std::vector<Index> ghosts = download(ghost);
    ghosts.resize(static_cast<std::size_t>(offsets.back()));
    return {output("ghost", ghosts), output("offset", offsets)};
  }

  Outputs reference() const {
    std::set<Index> all(mesh_ghost.begin(), mesh_ghost.end());
    for (const ContactOperatorEntry<T>& link : links)
      for (const Index v : link.v)
        if (v < row_begin[1] || v >= row_begin[2]) all.insert(v);
    std::vector<Index> offsets;
    for (const Index bound : row_begin)
      offsets.push_back(static_cast<Index>(std::distance(all.begin(), all.lower_bound(bound))));
    return {output("ghost", std::vector<Index>(all.begin(), all.end())), output("offset", offsets)};
  }
};

using Cases =
    testing::Types<HaloCase<float, true>, HaloCase<double, true>, HaloCase<double, false>>;
INSTANTIATE_TYPED_TEST_SUITE_P(SolveHalo, KernelParity, Cases);

}  // namespace
}  // namespace weft::parity
