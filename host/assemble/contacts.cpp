#include "weft/kernels/assemble/contacts.hpp"

#include <algorithm>
#include <cstdint>
#include <vector>

#include "host/exec/host_device.hpp"

namespace weft {
namespace {

struct Entry {
  Index item;
  std::int8_t i, j;  ///< corners: of the row, of the column
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

/// The terms of each contact and spring that has a corner in own rows, once for all of its rows.
template <class T>
std::vector<ContactTerms<T>> make_terms(const AssembleContacts<T>& a) {
  const Index row_end = a.row_begin + a.row_count;
  std::vector<ContactTerms<T>> terms(a.contacts.size() + a.springs.size());
  for (std::size_t n = 0; n < terms.size(); ++n) {
    const ContactItem<T> item = contact_item(a, n);
    if (std::any_of(item.v, item.v + item.corners,
                    [&](Index v) { return v >= a.row_begin && v < row_end; }))
      terms[n] = item_terms(a, n);
  }
  return terms;
}

template <class T>
void assemble_contacts(const AssembleContacts<T>& a) {
  list_row_corners(a);
  const std::vector<ContactTerms<T>> terms = make_terms(a);
  std::vector<Entry> entries;
  std::vector<std::uint64_t> order;  // by column, then by place in entries
  Offset slots = 0;
  a.matrix_slice_offset[0] = 0;
  for (std::size_t row = 0; row < static_cast<std::size_t>(a.row_count); ++row) {
    entries.clear();
    order.clear();
    for (Index e = a.row_entry_count[row]; e < a.row_entry_count[row + 1]; ++e) {
      const Index code = a.row_entry[static_cast<std::size_t>(e)];
      const Index n = code / 4;
      const int i = code % 4;
      const ContactItem<T> item = contact_item(a, static_cast<std::size_t>(n));
      a.rhs[row] += item.w[i] * terms[static_cast<std::size_t>(n)].impulse;
      for (int j = 0; j < item.corners; ++j) {
        if (item.v[j] >= a.cloth_vertex_count) continue;
        order.push_back(static_cast<std::uint64_t>(item.v[j]) << 32 | entries.size());
        entries.push_back({n, static_cast<std::int8_t>(i), static_cast<std::int8_t>(j)});
      }
    }
    std::sort(order.begin(), order.end());
    for (std::size_t e = 0; e < order.size();) {
      Mat3<T> sum{};
      const auto column = static_cast<Index>(order[e] >> 32);
      for (; e < order.size() && static_cast<Index>(order[e] >> 32) == column; ++e) {
        const Entry& entry = entries[order[e] & 0xffffffffu];
        const auto n = static_cast<std::size_t>(entry.item);
        const ContactItem<T> item = contact_item(a, n);
        sum += (item.w[entry.i] * item.w[entry.j]) * terms[n].block;
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
