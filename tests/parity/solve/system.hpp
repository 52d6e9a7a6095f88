#pragma once

#include <algorithm>
#include <map>
#include <numeric>

#include "tests/parity/support.hpp"
#include "weft/kernels/solve/pcg.hpp"

namespace weft::parity {

/// Rows of one matrix, by column.
template <class Entry>
using Rows = std::vector<std::map<Index, Entry>>;

/// A system like that of a sheet, of random numbers: blocks between neighbours on a lattice, mass
/// and drag on the diagonal, multiples of the identity between second neighbours, contacts between
/// vertices that have nothing to do with each other, some vertices fixed. Symmetric, positive
/// definite.
struct SheetSystem {
  Index across, up;
  Index count = across * up;
  std::vector<double> mass;
  std::vector<Mat3<double>> drag;
  Rows<Mat3<double>> mesh, contact;
  std::vector<ContactOperatorEntry<double>> links;  ///< what `contact` is the sum of
  Rows<double> far;
  std::vector<unsigned char> fixed;
  std::vector<Vec3<double>> rhs;

  /// @param seed of all numbers
  SheetSystem(Index columns, Index rows, std::uint32_t seed) : across(columns), up(rows) {
    Random random(seed);
    const auto all = static_cast<std::size_t>(count);
    mesh.resize(all);
    contact.resize(all);
    far.resize(all);
    mass = random.numbers<double>(all, 0.5, 1);
    for (Index v = 0; v < count; ++v) {
      const Vec3<double> d = random.vector<double>(-0.5, 0.5);
      drag.push_back(outer(d, d));
      mesh[at(v)][v] = mass[at(v)] * Mat3<double>::identity() + drag.back();
    }
    for (Index j = 0; j < up; ++j)
      for (Index i = 0; i < across; ++i)
        for (const auto& [di, dj] : {std::pair{1, 0}, {0, 1}, {1, 1}, {1, -1}}) {
          if (i + di < across && j + dj >= 0 && j + dj < up) join(random, i, j, di, dj);
          if (i + 2 * di < across && j + 2 * dj >= 0 && j + 2 * dj < up)
            join_off_pattern(random, i, j, 2 * di, 2 * dj);
        }
    for (int n = 0; n < 60; ++n) touch(random);
    fixed = random.marks(all, 40);
    rhs = random.vectors<double>(all, -1, 1);
  }

  void part_contacts() {
    links.clear();
    for (auto& row : contact) row.clear();
  }
  static std::size_t at(Index v) { return static_cast<std::size_t>(v); }
  Index vertex(Index i, Index j) const { return j * across + i; }

 private:
  void join(Random& random, Index i, Index j, Index di, Index dj) {
    const Vec3<double> d = random.vector<double>(-1, 1);
    couple(mesh, vertex(i, j), vertex(i + di, j + dj),
           random.uniform<double>(2, 8) * (outer(d, d) + 0.1 * Mat3<double>::identity()));
  }
  static void couple(Rows<Mat3<double>>& rows, Index a, Index b, const Mat3<double>& k) {
    rows[at(a)][a] += k;
    rows[at(b)][b] += k;
    rows[at(a)][b] -= k;
    rows[at(b)][a] -= k;
  }
  void join_off_pattern(Random& random, Index i, Index j, Index di, Index dj) {
    const Index a = vertex(i, j), b = vertex(i + di, j + dj);
    const double k = random.uniform<double>(0.1, 0.5);
    for (int c = 0; c < 3; ++c) {
      mesh[at(a)][a](c, c) += k;
      mesh[at(b)][b](c, c) += k;
    }
    far[at(a)][b] -= k;
    far[at(b)][a] -= k;
  }
  void touch(Random& random) {
    const Vec3<double> n = random.vector<double>(-1, 1);
    ContactOperatorEntry<double> link{{}, {1, -0.5, -0.25, -0.25}, {}};
    for (Index& corner : link.v)
      corner = static_cast<Index>(random.uniform<double>(0, 1) * double(count - 1));
    const Mat3<double> block = 20 * outer(n, n);
    const double upper[] = {block(0, 0), block(0, 1), block(0, 2),
                            block(1, 1), block(1, 2), block(2, 2)};
    std::copy(upper, upper + 6, link.block);
    links.push_back(link);
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j)
        contact[at(link.v[i])][link.v[j]] += (link.w[i] * link.w[j]) * block;
  }
};

/// Order of rows [begin, end) on a GPU: by their number of entries. Empty on hosts.
template <class Entry>
std::vector<Index> order_of(const Device& device, const Rows<Entry>& rows, Index begin, Index end) {
  std::vector<Index> packed;
  if (device.backend() != Backend::cuda) return packed;
  for (Index first = begin; first < end; first += RowOrder::window) {
    const Index count = std::min(RowOrder::window, end - first);
    std::vector<Index> row(static_cast<std::size_t>(count)), place(row);
    std::iota(row.begin(), row.end(), 0);
    const auto entries = [&](Index n) {
      return static_cast<Index>(rows[static_cast<std::size_t>(first + n)].size());
    };
    std::stable_sort(row.begin(), row.end(),
                     [&](Index a, Index b) { return entries(a) > entries(b); });
    for (Index p = 0; p < count; ++p)
      place[static_cast<std::size_t>(row[static_cast<std::size_t>(p)])] = p;
    for (std::size_t p = 0; p < row.size(); ++p)
      packed.push_back(RowOrder::pack(row[p], place[p], entries(row[p])));
  }
  return packed;
}

/// Rows [begin, end) of a matrix on a device, as BlockEll or ScalarEll has them.
template <class T>
struct SlicedRows {
  Index row_count = 0, slice = 1;
  Buffer<Offset> slice_offset;
  Buffer<Index> column;
  Buffer<T> value;
  Buffer<Index> order;

  SlicedRows() = default;
  /// @param packed see order_of()
  template <class Entry>
  SlicedRows(Device& device, const Rows<Entry>& rows, Index begin, Index end, Index height,
             const std::vector<Index>& packed)
      : row_count(end - begin), slice(height), order(upload(device, packed)) {
    const RowOrder places{packed};
    constexpr bool scalar = std::is_arithmetic_v<Entry>;
    constexpr std::size_t components = scalar ? 1 : 9;
    std::vector<Offset> offset{0};
    std::vector<Index> columns;
    std::vector<T> values;
    for (Index first = begin; first < end; first += slice) {
      std::size_t slots = 0;
      for (Index place = first; place < std::min(end, first + slice); ++place)
        slots = std::max(slots,
                         rows[static_cast<std::size_t>(begin + places.row(place - begin))].size());
      const std::size_t base = columns.size();
      const auto width = static_cast<std::size_t>(slice);
      columns.resize(base + slots * width);
      values.resize(components * columns.size(), T(0));
      for (std::size_t lane = 0; lane < width; ++lane) {
        const Index last = std::min(first + static_cast<Index>(lane), end - 1);
        const Index row = begin + places.row(last - begin);
        const bool exists = first + static_cast<Index>(lane) < end;
        auto entry = rows[static_cast<std::size_t>(row)].begin();
        for (std::size_t slot = 0; slot < slots; ++slot) {
          const bool real = exists && entry != rows[static_cast<std::size_t>(row)].end();
          columns[base + slot * width + lane] = real ? entry->first : row;
          if (!real) continue;
          T* at = values.data() + components * (base + slot * width) + lane;
          if constexpr (scalar)
            *at = static_cast<T>(entry->second);
          else
            for (std::size_t k = 0; k < 9; ++k) at[k * width] = static_cast<T>(entry->second.e[k]);
          ++entry;
        }
      }
      offset.push_back(offset.back() + static_cast<Offset>(slots));
    }
    slice_offset = upload(device, offset);
    column = upload(device, columns);
    value = upload(device, values);
  }

  BlockEll<T> blocks() const {
    return {row_count, slice, slice_offset.span(), column.span(), value.span(), {}, {order.span()}};
  }
  ScalarEll<T> scalars() const {
    return {row_count, slice, slice_offset.span(), column.span(), value.span(), {order.span()}};
  }
};

/// Rows [begin, end) of the mesh's matrix on a device: the blocks on the diagonal stand apart.
template <class T>
struct MeshMatrixRows {
  std::vector<Index> order;
  SlicedRows<T> others;
  Buffer<Mat3<T>> diagonal;

  MeshMatrixRows(Device& device, Rows<Mat3<double>> rows, Index begin, Index end, Index height) {
    std::vector<Mat3<T>> own;
    for (Index v = begin; v < end; ++v) {
      auto& row = rows[static_cast<std::size_t>(v)];
      own.emplace_back();
      for (int k = 0; k < 9; ++k) own.back().e[k] = static_cast<T>(row[v].e[k]);
      row.erase(v);
    }
    order = order_of(device, rows, begin, end);
    others = {device, rows, begin, end, height, order};
    diagonal = upload(device, own);
  }

  BlockEll<T> blocks() const {
    BlockEll<T> all = others.blocks();
    all.diagonal = diagonal.span();
    return all;
  }
};

/// Rows [begin, end) of the contact part on a device; without any links, there is none.
template <class T>
struct ContactOperatorRows {
  Buffer<ContactOperatorEntry<T>> link;
  Buffer<Index> count, end_offset;
  Buffer<ContactScatter<T>> end;
  Buffer<ContactGather<T>> pull;
  bool some;

  ContactOperatorRows(Device& device, const std::vector<ContactOperatorEntry<double>>& all,
                      Index begin, Index end_row)
      : some(!all.empty()) {
    std::vector<ContactOperatorEntry<T>> own;
    std::vector<std::vector<ContactScatter<T>>> rows(static_cast<std::size_t>(end_row - begin));
    for (const ContactOperatorEntry<double>& each : all) {
      const auto here = [&](Index v) { return v >= begin && v < end_row; };
      if (std::none_of(each.v, each.v + 4, here)) continue;
      ContactOperatorEntry<T> made{};
      for (int j = 0; j < 4; ++j) {
        made.v[j] = each.v[j];
        made.w[j] = static_cast<T>(each.w[j]);
        if (here(each.v[j]))
          rows[static_cast<std::size_t>(each.v[j] - begin)].push_back(
              {static_cast<Index>(own.size()), made.w[j]});
      }
      std::transform(each.block, each.block + 6, made.block,
                     [](double x) { return static_cast<T>(x); });
      own.push_back(made);
    }
    std::vector<Index> offset{0};
    std::vector<ContactScatter<T>> ends;
    for (const auto& row : rows) {
      ends.insert(ends.end(), row.begin(), row.end());
      offset.push_back(static_cast<Index>(ends.size()));
    }
    link = upload(device, own);
    count = upload(device, std::vector<Index>{static_cast<Index>(own.size())});
    end_offset = upload(device, offset);
    end = upload(device, ends);
    pull = Buffer<ContactGather<T>>(device, own.size());
  }

  ContactOperator<T> view() const {
    if (!some) return {};
    return {link.span(), count.span(), end_offset.span(), end.span(), pull.span()};
  }
};

}  // namespace weft::parity
