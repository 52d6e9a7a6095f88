#include "weft/kernels/assemble/contacts.hpp"

#include <map>

#include "tests/parity/assemble/contact_set.hpp"

namespace weft::parity {
namespace {

/// The matrix that links stand for, as BlockEll has its values: row by row, columns ascending.
template <class T>
std::vector<double> values_of(const std::vector<ContactLink<T>>& links,
                              const std::vector<Index>& end_offset,
                              const std::vector<LinkEnd<T>>& ends) {
  static constexpr int upper[9] = {0, 1, 2, 1, 3, 4, 2, 4, 5};
  std::vector<double> values;
  for (std::size_t row = 0; row + 1 < end_offset.size(); ++row) {
    std::map<Index, Mat3<double>> blocks;
    for (auto e = static_cast<std::size_t>(end_offset[row]);
         e < static_cast<std::size_t>(end_offset[row + 1]); ++e) {
      const ContactLink<T>& link = links[static_cast<std::size_t>(ends[e].link)];
      for (int j = 0; j < 4; ++j)
        for (int k = 0; k < 9; ++k)
          blocks[link.v[j]].e[k] +=
              double{ends[e].weight} * double{link.w[j]} * double{link.block[upper[k]]};
    }
    for (const auto& [column, block] : blocks) values.insert(values.end(), block.e, block.e + 9);
  }
  return values;
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
    }
  }

  Outputs compute(Device& device, Index parts) const {
    std::vector<double> columns, values, linked, lengths;
    std::vector<Vec3<T>> sums(row_count);
    const bool links = device.backend() == Backend::cuda;
    const auto contacts_d = upload(device, set.contacts);
    const auto springs_d = upload(device, springs);
    const auto x = upload(device, set.positions), x0 = upload(device, set.positions_t0);
    auto pieces = parts_of(row_count, parts);
    std::reverse(pieces.begin(), pieces.end());
    for (const auto& [begin, size] : pieces) {
      const auto rows = static_cast<std::size_t>(size);
      const std::size_t entries = 16 * set.contacts.size() + 4 * springs.size();
      const Buffer<Index> count(device, rows + 1), entry(device, entries / 2);
      const Buffer<Offset> offset(device, rows + 1);
      const Buffer<Index> column(device, entries);
      const Buffer<T> value(device, 9 * entries);
      const Buffer<ContactLink<T>> link(device, links ? entries / 4 : 0);
      const Buffer<Index> link_count(device, links ? 1 : 0);
      const Buffer<LinkEnd<T>> link_end(device, links ? entries / 2 : 0);
      const auto rhs_d =
          upload(device, std::vector<Vec3<T>>(rhs.begin() + begin, rhs.begin() + begin + size));
      launch(device.compute(),
             AssembleContacts<T>{row_begin + begin, size, set.cloth, contacts_d.span(),
                                 springs_d.span(), x.span(), x0.span(), h, as_taken, count.span(),
                                 entry.span(), offset.span(), column.span(), value.span(),
                                 rhs_d.span(), link.span(), link_count.span(), link_end.span()});
      const std::vector<Offset> starts = download(offset);
      const std::vector<Index> all_columns = download(column);
      const std::vector<T> all_values = download(value);
      const std::vector<Vec3<T>> own = download(rhs_d);
      std::copy(own.begin(), own.end(), sums.begin() + begin);
      for (std::size_t r = 0; r < rows; ++r) {
        lengths.push_back(static_cast<double>(starts[r + 1] - starts[r]));
        for (auto e = static_cast<std::size_t>(starts[r]);
             e < static_cast<std::size_t>(starts[r + 1]); ++e) {
          columns.push_back(static_cast<double>(all_columns[e]));
          for (std::size_t k = 0; k < 9; ++k) values.push_back(double{all_values[9 * e + k]});
        }
      }
      if (!links) continue;
      const std::vector<double> part =
          values_of(download(link), download(count), download(link_end));
      linked.insert(linked.end(), part.begin(), part.end());
      EXPECT_LE(static_cast<std::size_t>(download(link_count).front()),
                set.contacts.size() + springs.size());
    }
    return {{"length", lengths},
            {"column", columns},
            {"value", values},
            {"linked value", links ? linked : values},
            output("rhs", sums)};
  }

  /// Every contact and spring by itself, into a map of blocks.
  Outputs reference() const {
    AssembleContacts<double> a;
    const std::vector<Vec3<double>> x = in_double(set.positions), x0 = in_double(set.positions_t0);
    a.positions = x;
    a.positions_t0 = x0;
    a.h = double{h};
    a.as_taken = as_taken;
    std::map<Index, std::map<Index, Mat3<double>>> matrix;
    std::vector<Vec3<double>> sums = in_double(rhs);
    const auto scatter = [&](int corners, const Index* v, const double* w,
                             const ContactTerms<double>& terms) {
      for (int i = 0; i < corners; ++i) {
        if (v[i] < row_begin || v[i] >= row_begin + row_count) continue;
        sums[static_cast<std::size_t>(v[i] - row_begin)] += w[i] * terms.impulse;
        for (int j = 0; j < corners; ++j)
          if (v[j] < set.cloth) matrix[v[i] - row_begin][v[j]] += (w[i] * w[j]) * terms.block;
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
                                             double{s.rest}}));
    }
    std::vector<double> lengths, columns;
    std::vector<Mat3<double>> values;
    for (Index r = 0; r < row_count; ++r) {
      lengths.push_back(static_cast<double>(matrix[r].size()));
      for (const auto& [column, block] : matrix[r]) {
        columns.push_back(column);
        values.push_back(block);
      }
    }
    return {{"length", lengths},
            {"column", columns},
            output("value", values),
            output("linked value", values),
            output("rhs", sums)};
  }
};

using Cases = testing::Types<ContactsCase<float, true>, ContactsCase<float, false>,
                             ContactsCase<double, true>, ContactsCase<double, false>>;
INSTANTIATE_TYPED_TEST_SUITE_P(AssembleContacts, KernelParity, Cases);

}  // namespace
}  // namespace weft::parity
