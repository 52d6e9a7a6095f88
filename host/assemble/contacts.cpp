#include "weft/kernels/assemble/contacts.hpp"

#include <algorithm>
#include <vector>

#include "host/exec/host_device.hpp"

namespace weft {
namespace {

struct Entry {
  Index column;
  Index item;  ///< place in the row's list
  std::int8_t i, j;
};

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
  std::vector<Entry> entries;
  std::vector<ContactItem<T>> items;
  std::vector<ContactTerms<T>> terms;
  Offset slots = 0;
  a.matrix_slice_offset[0] = 0;
  for (std::size_t row = 0; row < static_cast<std::size_t>(a.row_count); ++row) {
    entries.clear();
    items.clear();
    terms.clear();
    for (Index e = a.row_entry_count[row]; e < a.row_entry_count[row + 1]; ++e) {
      const Index code = a.row_entry[static_cast<std::size_t>(e)];
      const auto n = static_cast<std::size_t>(code / 4);
      const int i = code % 4;
      items.push_back(contact_item(a, n));
      terms.push_back(item_terms(a, n));
      const ContactItem<T>& item = items.back();
      a.rhs[row] += item.w[i] * terms.back().impulse;
      for (int j = 0; j < item.corners; ++j)
        if (item.v[j] < a.cloth_vertex_count)
          entries.push_back({item.v[j], static_cast<Index>(terms.size() - 1),
                             static_cast<std::int8_t>(i), static_cast<std::int8_t>(j)});
    }
    std::stable_sort(entries.begin(), entries.end(),
                     [](const Entry& p, const Entry& q) { return p.column < q.column; });
    for (std::size_t e = 0; e < entries.size();) {
      Mat3<T> sum{};
      const Index column = entries[e].column;
      for (; e < entries.size() && entries[e].column == column; ++e) {
        const auto n = static_cast<std::size_t>(entries[e].item);
        sum += (items[n].w[entries[e].i] * items[n].w[entries[e].j]) * terms[n].block;
      }
      a.matrix_column[static_cast<std::size_t>(slots)] = column;
      for (int k = 0; k < 9; ++k)
        a.matrix_value[static_cast<std::size_t>(slots * 9 + k)] = sum.e[k];
      ++slots;
    }
    a.matrix_slice_offset[row + 1] = slots;
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
