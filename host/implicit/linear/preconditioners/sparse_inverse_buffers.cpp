#include "host/implicit/linear/preconditioners/sparse_inverse_buffers.hpp"

#include <algorithm>
#include <type_traits>

#include "host/state/store.hpp"

namespace weft {
namespace {

/// An entry with nothing in it.
SparseInverseEntry empty_entry(Index column) {
  SparseInverseEntry entry;
  entry.column = column;
  return entry;
}

/// Neighbours of a vertex at most that lead to further ones: a hub would make pairs of all its own.
constexpr std::size_t hub = 64;

/// The rows up to two edges before `row`, without repetition; those beyond a hub are left out, and
/// so are those that do not stay within the domain.
std::vector<Index> candidates(const std::vector<std::vector<Index>>& neighbours, Index row,
                              Index domain) {
  const Index first = row / domain * domain;
  std::vector<Index> found;
  for (const Index near : neighbours[static_cast<std::size_t>(row)]) {
    if (near / domain * domain != first) continue;
    if (near < row) found.push_back(near);
    if (neighbours[static_cast<std::size_t>(near)].size() > hub) continue;
    for (const Index far : neighbours[static_cast<std::size_t>(near)])
      if (far >= first && far < row) found.push_back(far);
  }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

}  // namespace

std::vector<std::vector<Index>> sparse_inverse_pattern(
    const std::vector<std::vector<Index>>& neighbours, const std::vector<Vec2<double>>& points,
    Index domain) {
  std::vector<std::vector<Index>> pattern(neighbours.size());
  std::vector<std::pair<double, Index>> near;
  for (std::size_t row = 0; row < neighbours.size(); ++row) {
    near.clear();
    for (const Index other : candidates(neighbours, static_cast<Index>(row), domain)) {
      const Vec2<double> d = points[static_cast<std::size_t>(other)] - points[row];
      near.emplace_back(dot(d, d), other);
    }
    std::sort(near.begin(), near.end());
    near.resize(std::min(near.size(), std::size_t{sparse_inverse_width - 1}));
    for (const auto& [distance, other] : near) pattern[row].push_back(other);
    std::sort(pattern[row].begin(), pattern[row].end());
  }
  return pattern;
}

std::vector<std::vector<Index>> mesh_neighbours(const std::vector<Offset>& slice_offset,
                                                const std::vector<Index>& column, Index slice,
                                                Index begin, Index rows) {
  std::vector<std::vector<Index>> neighbours(static_cast<std::size_t>(rows));
  for (Index row = 0; row < rows; ++row) {
    const auto n = static_cast<std::size_t>(row / slice);
    for (Offset slot = slice_offset[n]; slot < slice_offset[n + 1]; ++slot) {
      const Index other = column[static_cast<std::size_t>(slot * slice + row % slice)] - begin;
      if (other != row && other >= 0 && other < rows)
        neighbours[static_cast<std::size_t>(row)].push_back(other);
    }
  }
  return neighbours;
}

void SparseInverseBuffers::make(Device& device, const std::vector<std::vector<Index>>& pattern,
                                Index slice) {
  const auto rows = static_cast<Index>(pattern.size());
  const Index slices = (rows + slice - 1) / slice;
  std::vector<Index> above(pattern.size(), 1);  // entries of the transpose's rows
  for (const auto& row : pattern)
    for (const Index other : row) ++above[static_cast<std::size_t>(other)];
  std::vector<Offset> offset{0};
  for (Index first = 0; first < rows; first += slice) {
    Index longest = 0;
    for (Index row = first; row < std::min(rows, first + slice); ++row)
      longest = std::max(longest, above[static_cast<std::size_t>(row)]);
    offset.push_back(offset.back() + longest);
  }
  const auto lanes = static_cast<std::size_t>(slice);
  std::vector<SparseInverseEntry> lower(static_cast<std::size_t>(slices) * sparse_inverse_width *
                                        lanes);
  std::vector<SparseInverseEntry> upper(static_cast<std::size_t>(offset.back()) * lanes);
  std::vector<Offset> place(lower.size(), -1);
  factor_ = {rows, slice, {}, {}, {}, {}};
  for (Index row = 0; row < rows; ++row) {
    const auto n = static_cast<std::size_t>(row / slice);
    for (Offset slot = offset[n]; slot < offset[n + 1]; ++slot)
      upper[static_cast<std::size_t>(slot * slice + row % slice)] = empty_entry(row);
  }
  std::vector<Index> filled(pattern.size(), 0);
  for (Index row = 0; row < rows; ++row) {
    const std::vector<Index>& before = pattern[static_cast<std::size_t>(row)];
    for (int k = 0; k < sparse_inverse_width; ++k) {
      const bool used = k <= static_cast<int>(before.size());
      const Index other = k == 0 || !used ? row : before[static_cast<std::size_t>(k - 1)];
      const auto at = static_cast<std::size_t>(factor_.lower_place(row, k));
      lower[at] = empty_entry(other);
      if (!used) continue;
      const Offset slot = offset[static_cast<std::size_t>(other / slice)] +
                          filled[static_cast<std::size_t>(other)]++;
      place[at] = slot * slice + other % slice;
    }
  }
  const auto put = [&](auto& buffer, const auto& values) {
    buffer = std::remove_reference_t<decltype(buffer)>(device);
    upload(device.compute(), buffer, values);
    return buffer.span();
  };
  factor_.lower = put(lower_, lower);
  factor_.upper_offset = put(upper_offset_, offset);
  factor_.upper = put(upper_, upper);
  factor_.place = put(place_, place);
  device.compute().sync();
}

}  // namespace weft
