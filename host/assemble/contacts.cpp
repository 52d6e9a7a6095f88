#include "weft/kernels/assemble/contacts.hpp"

#include <algorithm>
#include <vector>

#include "host/exec/host_device.hpp"

namespace weft {
namespace {

/// Lists, row by row and in the order of contacts and springs, their corners in own rows.
template <class T>
void list_row_corners(const AssembleContacts<T>& a) {
  const auto rows = static_cast<std::size_t>(a.row_count);
  const Index row_end = a.row_begin + a.row_count;
  const auto visit = [&](auto use) {
    for (std::size_t n = 0; n < a.contacts.size() + a.springs.size(); ++n) {
      const ContactItem<T> item = contact_item(a, n);
      for (int j = 0; j < item.corners; ++j)
        if (item.v[j] >= a.row_begin && item.v[j] < row_end)
          use(static_cast<std::size_t>(item.v[j] - a.row_begin), 4 * static_cast<Index>(n) + j);
    }
  };
  std::fill(a.row_entry_count.begin(), a.row_entry_count.begin() + rows + 1, 0);
  visit([&](std::size_t row, Index) { ++a.row_entry_count[row + 1]; });
  for (std::size_t r = 0; r < rows; ++r) a.row_entry_count[r + 1] += a.row_entry_count[r];
  visit([&](std::size_t row, Index code) {
    a.row_entry[static_cast<std::size_t>(a.row_entry_count[row]++)] = code;
  });
  // Filling moved each start to the next one's place; move them back.
  for (std::size_t r = rows; r > 0; --r) a.row_entry_count[r] = a.row_entry_count[r - 1];
  a.row_entry_count[0] = 0;
}

template <class T>
void assemble_contacts(const AssembleContacts<T>& a) {
  list_row_corners(a);
  const Index row_end = a.row_begin + a.row_count;
  const std::size_t items = a.contacts.size() + a.springs.size();
  std::vector<Index> place(items);  // number of an item's link
  std::vector<Vec3<T>> impulse;     // [N s] of each link
  impulse.reserve(items);
  for (std::size_t n = 0; n < items; ++n) {
    const ContactItem<T> item = contact_item(a, n);
    if (std::none_of(item.v, item.v + item.corners,
                     [&](Index v) { return v >= a.row_begin && v < row_end; }))
      continue;
    const ContactTerms<T> terms = item_terms(a, n);
    place[n] = static_cast<Index>(impulse.size());
    a.link[impulse.size()] = contact_operator_entry(item, terms.block, a.cloth_vertex_count);
    impulse.push_back(terms.impulse);
  }
  a.contact_entry_count[0] = static_cast<Index>(impulse.size());
  for (std::size_t row = 0; row < static_cast<std::size_t>(a.row_count); ++row)
    for (auto e = static_cast<std::size_t>(a.row_entry_count[row]);
         e < static_cast<std::size_t>(a.row_entry_count[row + 1]); ++e) {
      const auto link =
          static_cast<std::size_t>(place[static_cast<std::size_t>(a.row_entry[e] / 4)]);
      const T weight = a.link[link].w[a.row_entry[e] % 4];
      a.contact_scatter[e] = {static_cast<Index>(link), weight};
      a.rhs[row] += weight * impulse[link];
    }
}

}  // namespace

template <class T>
void run(OnHost, Queue& queue, const AssembleContacts<T>& args) {
  submit_host(queue, [args] { assemble_contacts(args); });
}

template void run(OnHost, Queue&, const AssembleContacts<float>&);
template void run(OnHost, Queue&, const AssembleContacts<double>&);

}  // namespace weft
