#include "weft/kernels/assemble/contacts.hpp"

#include <map>

#include "tests/parity/assemble/contact_set.hpp"

namespace weft::parity {
namespace {

/// Rows of a contact part: columns ascending, and their blocks.
using BlockRows = std::vector<std::map<Index, Mat3<double>>>;

template <class T>
BlockRows rows_of(const std::vector<ContactOperatorEntry<T>>& links,
                  const std::vector<Index>& end_offset,
                  const std::vector<ContactScatter<T>>& ends) {
  BlockRows rows(end_offset.size() - 1);
  for (std::size_t row = 0; row < rows.size(); ++row)
    for (auto e = static_cast<std::size_t>(end_offset[row]);
         e < static_cast<std::size_t>(end_offset[row + 1]); ++e) {
      const ContactOperatorEntry<T>& link = links[static_cast<std::size_t>(ends[e].link)];
      for (int j = 0; j < 4; ++j)
        for (int k = 0; k < 9; ++k)
          rows[row][link.v[j]].e[k] +=
              double{ends[e].weight} * double{link.w[j]} * double{link.component(k)};
    }
  return rows;
}

/// Rows 40 to 339 of the cloth's 400, with springs to places and to other vertices.
template <class T, bool as_taken>
struct ContactsCase {
  using Scalar = T;
  static constexpr Index row_begin = 40, row_count = 300;
  ContactSet<T> set{18, 300};
  std::vector<Spring<T>> springs;
  std::vector<Vec3<T>> rhs = set.random.template vectors<T>(row_count, -1e-3, 1e-3);
  T h = T(0.0078125);

  ContactsCase() {
    for (int n = 0; n < 50; ++n) {
      const Index from = set.vertex(set.cloth);
      springs.push_back({{from, n % 2 == 0 ? -1 : (from + 13) % set.cloth},
                         set.random.template vector<T>(-0.2, 0.2),
                         set.random.template uniform<T>(5, 10),
                         set.random.template uniform<T>(0, 0.05)});
      if (n % 4 == 0) springs.back().rest = 0;
      if (n % 4 == 1) springs.back().drag = set.random.template uniform<T>(5, 10);
      const Vec3<double> along = set.random.template vector<double>(0.1, 1);
      if (n % 4 == 0) springs.back().along = vec_cast<T>((1 / length(along)) * along);
    }
  }

  Outputs compute(Device& device, Index parts) const {
    std::vector<Vec3<T>> sums(row_count);
    BlockRows all;
    const auto contacts_d = upload(device, set.contacts);
    const auto springs_d = upload(device, springs);
    const auto x = upload(device, set.positions), x0 = upload(device, set.positions_t0);
    for (const auto& [begin, size] : parts_of(row_count, parts)) {
      const auto rows = static_cast<std::size_t>(size);
      const std::size_t ends = 4 * set.contacts.size() + 2 * springs.size();
      const Buffer<Index> count(device, rows + 1), entry(device, ends);
      const Buffer<ContactOperatorEntry<T>> link(device, set.contacts.size() + springs.size());
      const Buffer<Index> contact_entry_count(device, 1);
      const Buffer<ContactScatter<T>> contact_scatter(device, ends);
      const auto rhs_d =
          upload(device, std::vector<Vec3<T>>(rhs.begin() + begin, rhs.begin() + begin + size));
      launch(device.compute(),
             AssembleContacts<T>{row_begin + begin, size, set.cloth, contacts_d.span(),
                                 springs_d.span(), x.span(), x0.span(), h, as_taken, count.span(),
                                 entry.span(), rhs_d.span(), link.span(),
                                 contact_entry_count.span(), contact_scatter.span()});
      const std::vector<Vec3<T>> own = download(rhs_d);
      std::copy(own.begin(), own.end(), sums.begin() + begin);
      const BlockRows made = rows_of(download(link), download(count), download(contact_scatter));
      all.insert(all.begin(), made.begin(), made.end());
      EXPECT_LE(static_cast<std::size_t>(download(contact_entry_count).front()), link.size());
    }
    return outputs(all, sums);
  }

  /// Every contact and spring by itself, into a map of blocks.
  Outputs reference() const {
    AssembleContacts<double> a;
    const std::vector<Vec3<double>> x = in_double(set.positions), x0 = in_double(set.positions_t0);
    a.positions = x;
    a.positions_t0 = x0;
    a.h = double{h};
    a.as_taken = as_taken;
    BlockRows matrix(row_count);
    std::vector<Vec3<double>> sums = in_double(rhs);
    const auto scatter = [&](int corners, const Index* v, const double* w,
                             const ContactTerms<double>& terms) {
      for (int i = 0; i < corners; ++i) {
        if (v[i] < row_begin || v[i] >= row_begin + row_count) continue;
        sums[static_cast<std::size_t>(v[i] - row_begin)] += w[i] * terms.impulse;
        for (int j = 0; j < corners; ++j)
          if (v[j] < set.cloth)
            matrix[static_cast<std::size_t>(v[i] - row_begin)][v[j]] += (w[i] * w[j]) * terms.block;
      }
    };
    for (const Contact<T>& c : set.contacts) {
      const Contact<double> d = in_double(c);
      scatter(4, d.v, d.w, contact_terms(a, d));
    }
    for (const Spring<T>& s : springs) {
      const double w[2] = {1, -1};
      scatter(s.v[1] < 0 ? 1 : 2, s.v, w,
              spring_terms(a, Spring<double>{{s.v[0], s.v[1]},
                                             vec_cast<double>(s.anchor),
                                             double{s.stiffness},
                                             double{s.rest},
                                             vec_cast<double>(s.along),
                                             double{s.drag}}));
    }
    return outputs(matrix, sums);
  }

 private:
  template <class Sum>
  static Outputs outputs(const BlockRows& rows, const std::vector<Vec3<Sum>>& sums) {
    std::vector<double> lengths, columns;
    std::vector<Mat3<double>> values;
    for (const auto& row : rows) {
      lengths.push_back(static_cast<double>(row.size()));
      for (const auto& [column, block] : row) {
        columns.push_back(column);
        values.push_back(block);
      }
    }
    return {{"length", lengths}, {"column", columns}, output("value", values), output("rhs", sums)};
  }
};

using Cases = testing::Types<ContactsCase<float, true>, ContactsCase<float, false>,
                             ContactsCase<double, true>, ContactsCase<double, false>>;
INSTANTIATE_TYPED_TEST_SUITE_P(AssembleContacts, KernelParity, Cases);

}  // namespace
}  // namespace weft::parity
