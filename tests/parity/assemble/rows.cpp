#include "weft/kernels/assemble/rows.hpp"

#include <map>

#include "tests/parity/support.hpp"

namespace weft::parity {
namespace {

constexpr Index slice = 8;
constexpr double untouched = 7;  ///< value of lanes without a row, before and after

/// Pattern and gather tables of the rows of one rank, made from the elements in ascending order.
struct Tables {
  std::vector<Offset> slice_offset{0}, block_offset{0}, corner_offset{0};
  std::vector<Index> column, block_source, corner_source;

  Tables(const std::vector<Tri>& triangles, const std::vector<Hinge>& hinges, Index row_begin,
         Index row_count) {
    const auto rows = static_cast<std::size_t>(row_count);
    std::vector<std::map<Index, std::vector<Index>>> blocks(rows);
    std::vector<std::vector<Index>> corners(rows);
    const auto add = [&](const Index* v, int corner_count, Index n, bool is_hinge) {
      for (Index i = 0; i < corner_count; ++i) {
        const Index row = v[i] - row_begin;
        if (row < 0 || row >= row_count) continue;
        const auto r = static_cast<std::size_t>(row);
        corners[r].push_back(is_hinge ? -1 - (4 * n + i) : 3 * n + i);
        for (Index j = 0; j < corner_count; ++j) {
          if (j == i) continue;
          blocks[r][v[j]].push_back(is_hinge ? -1 - (16 * n + 4 * i + j) : 9 * n + 3 * i + j);
        }
      }
    };
    for (std::size_t n = 0; n < triangles.size(); ++n)
      add(triangles[n].v, 3, static_cast<Index>(n), false);
    for (std::size_t n = 0; n < hinges.size(); ++n)
      add(hinges[n].v, 4, static_cast<Index>(n), true);
    for (const auto& sources : corners) {
      corner_source.insert(corner_source.end(), sources.begin(), sources.end());
      corner_offset.push_back(static_cast<Offset>(corner_source.size()));
    }
    for (std::size_t first = 0; first < rows; first += slice) add_slice(blocks, first, row_begin);
  }

  void add_slice(const std::vector<std::map<Index, std::vector<Index>>>& blocks, std::size_t first,
                 Index row_begin) {
    std::size_t width = 0;
    for (std::size_t r = first; r < std::min(first + slice, blocks.size()); ++r)
      width = std::max(width, blocks[r].size());
    for (std::size_t slot = 0; slot < width; ++slot)
      for (std::size_t r = first; r < first + slice; ++r) {
        Index own = -1;
        if (r < blocks.size()) {
          own = row_begin + static_cast<Index>(r);
          if (slot < blocks[r].size()) {
            const auto& [other, sources] = *std::next(blocks[r].begin(), static_cast<int>(slot));
            own = other;
            block_source.insert(block_source.end(), sources.begin(), sources.end());
          }
        }
        column.push_back(own);
        block_offset.push_back(static_cast<Offset>(block_source.size()));
      }
    slice_offset.push_back(slice_offset.back() + static_cast<Offset>(width));
  }
};

/// Vertices 40 to 339 of a sheet of 399; elements of arbitrary values.
template <class T, bool with_velocities>
struct RowsCase {
  using Scalar = T;
  static constexpr Index row_begin = 40, row_count = 300;
  Random random{10};
  Sheet<T> sheet{random};
  std::size_t vertex_count = sheet.positions.size();
  Tables tables{sheet.triangles, sheet.hinges, row_begin, row_count};
  std::vector<Mat3<T>> block = std::vector<Mat3<T>>(6 * sheet.triangles.size());
  std::vector<Vec3<T>> impulse = random.vectors<T>(3 * sheet.triangles.size(), -1, 1);
  std::vector<Vec3<T>> direction = random.vectors<T>(4 * sheet.hinges.size(), -1, 1);
  std::vector<T> impulse_scale = random.numbers<T>(sheet.hinges.size(), -1, 1);
  std::vector<T> curvature = random.numbers<T>(sheet.hinges.size(), 0, 1);
  std::vector<Mat3<T>> drag;
  std::vector<T> mass = random.numbers<T>(vertex_count, 0.5, 1);
  std::vector<T> damping_mass = random.numbers<T>(vertex_count, 0, 20);
  std::vector<Vec3<T>> base_velocities = random.vectors<T>(vertex_count, -2, 2);
  std::vector<Vec3<T>> velocities =
      with_velocities ? random.vectors<T>(vertex_count, -2, 2) : std::vector<Vec3<T>>{};
  Vec3<T> gravity{T(0.5), T(-0.25), T(-9.75)};
  T h = T(0.0625);

  RowsCase() {
    for (std::size_t n = 0; with_velocities && n < sheet.triangles.size(); ++n) {
      drag.emplace_back();
      for (T& value : drag[n].e) value = random.uniform<T>(-1, 1);
    }
    for (std::size_t n = 0; n < block.size(); ++n) {
      for (T& value : block[n].e) value = random.uniform<T>(-1, 1);
      // Blocks 00, 11 and 22 are symmetric, as a Hessian's are.
      if (n % 6 == 0 || n % 6 == 3 || n % 6 == 5)
        for (int i = 0; i < 3; ++i)
          for (int j = 0; j < i; ++j) block[n](i, j) = block[n](j, i);
    }
  }

  Outputs compute(Device& device, Index parts) const {
    const auto slice_offset_d = upload(device, tables.slice_offset);
    const auto column_d = upload(device, tables.column);
    const auto block_offset_d = upload(device, tables.block_offset);
    const auto block_source_d = upload(device, tables.block_source);
    const auto corner_offset_d = upload(device, tables.corner_offset);
    const auto corner_source_d = upload(device, tables.corner_source);
    const auto block_d = upload(device, block);
    const auto impulse_d = upload(device, impulse), direction_d = upload(device, direction);
    const auto impulse_scale_d = upload(device, impulse_scale);
    const auto curvature_d = upload(device, curvature);
    const auto drag_d = upload(device, drag);
    const auto mass_d = upload(device, mass), damping_d = upload(device, damping_mass);
    const auto base_d = upload(device, base_velocities), v = upload(device, velocities);
    const auto value = upload(device, std::vector<T>(9 * tables.column.size(), T(untouched)));
    const Buffer<Vec3<T>> rhs(device, row_count);
    const Buffer<T> vertex_mass(device, row_count);
    const Buffer<Mat3<T>> diagonal(device, row_count);
    const Buffer<T> vertex_drag(device, drag.empty() ? 0 : RowBlocks<T>::size(row_count, 1));
    for (const auto& [begin, size] : parts_of(row_count, parts, slice)) {
      const auto b = static_cast<std::size_t>(begin);
      const std::size_t s = b / slice;
      AssembleRows<T> args;
      args.row_begin = row_begin + begin;
      args.matrix = {size,
                     slice,
                     slice_offset_d.span().subspan(s, slice_offset_d.size() - s),
                     column_d.span(),
                     value.span(),
                     diagonal.span().subspan(b, static_cast<std::size_t>(size))};
      args.block_source_offset = block_offset_d.span();
      args.block_source = block_source_d.span();
      args.corner_source_offset = corner_offset_d.span().subspan(b, corner_offset_d.size() - b);
      args.corner_source = corner_source_d.span();
      args.triangle_block = block_d.span();
      args.triangle_impulse = impulse_d.span();
      args.hinge_direction = direction_d.span();
      args.hinge_impulse_scale = impulse_scale_d.span();
      args.hinge_curvature = curvature_d.span();
      args.mass = mass_d.span();
      args.damping_mass = damping_d.span();
      args.base_velocities = base_d.span();
      args.velocities = v.span();
      args.gravity = gravity;
      args.h = h;
      args.rhs = rhs.span().subspan(b, static_cast<std::size_t>(size));
      args.vertex_mass = vertex_mass.span().subspan(b, static_cast<std::size_t>(size));
      args.corner_drag = drag_d.span();
      if (!drag.empty()) args.vertex_drag = RowBlocks<T>{1, vertex_drag.span()}.from(begin);
      launch(device.compute(), args);
    }
    Outputs outputs = {output("value", download(value)), output("diagonal", download(diagonal)),
                       output("rhs", download(rhs)), output("mass", download(vertex_mass))};
    if (!drag.empty()) outputs.push_back(output("drag", download(vertex_drag)));
    return outputs;
  }

  /// Element by element into a map of blocks, without the gather tables; then laid out as the
  /// pattern says.
  Outputs reference() const {
    std::map<std::pair<Index, Index>, Mat3<double>> sum;
    std::vector<Vec3<double>> rhs(vertex_count);
    std::vector<double> vertex_mass;
    std::vector<Mat3<double>> diagonal;
    std::vector<Mat3<double>> vertex_drag(drag.empty() ? 0 : vertex_count);
    scatter_triangles(sum, rhs);
    scatter_hinges(sum, rhs);
    for (std::size_t v = 0; v < vertex_count; ++v) {
      const double m = double{mass[v]}, damped = m * (1 + double{h} * double{damping_mass[v]});
      const auto n = static_cast<Index>(v);
      if (n >= row_begin && n < row_begin + row_count) vertex_mass.push_back(damped);
      rhs[v] += m * (vec_cast<double>(base_velocities[v]) + double{h} * vec_cast<double>(gravity));
      if (with_velocities) rhs[v] -= damped * vec_cast<double>(velocities[v]);
    }
    for (std::size_t n = 0; n < drag.size(); ++n)
      for (const Index v : sheet.triangles[n].v)
        for (int k = 0; k < 9; ++k)
          vertex_drag[static_cast<std::size_t>(v)].e[k] += double{drag[n].e[k]};
    if (!drag.empty())
      vertex_drag = {vertex_drag.begin() + row_begin, vertex_drag.begin() + row_begin + row_count};
    std::vector<double> value(9 * tables.column.size(), untouched);
    for (Index r = 0; r < row_count; ++r) {
      const auto s = static_cast<std::size_t>(r / slice),
                 lane = static_cast<std::size_t>(r % slice);
      sum.erase({row_begin + r, row_begin + r});  // the engine sums the others
      auto entry = sum.lower_bound({row_begin + r, 0});
      diagonal.push_back(vertex_mass[static_cast<std::size_t>(r)] * Mat3<double>::identity());
      if (!drag.empty()) diagonal.back() += vertex_drag[static_cast<std::size_t>(r)];
      for (auto e = entry; e != sum.end() && e->first.first == row_begin + r; ++e)
        diagonal.back() -= e->second;
      diagonal.back() = 0.5 * (diagonal.back() + transpose(diagonal.back()));
      for (auto slot = static_cast<std::size_t>(tables.slice_offset[s]);
           slot < static_cast<std::size_t>(tables.slice_offset[s + 1]); ++slot) {
        const bool padding = entry == sum.end() || entry->first.first != row_begin + r;
        for (std::size_t k = 0; k < 9; ++k)
          value[(slot * 9 + k) * slice + lane] = padding ? 0.0 : entry->second.e[k];
        if (!padding) ++entry;
      }
    }
    Outputs outputs = {
        output("value", value), output("diagonal", diagonal),
        output("rhs", std::vector<Vec3<double>>(rhs.begin() + row_begin,
                                                rhs.begin() + row_begin + row_count)),
        output("mass", vertex_mass)};
    if (!drag.empty()) outputs.push_back(output("drag", vertex_drag));
    return outputs;
  }

  void scatter_triangles(std::map<std::pair<Index, Index>, Mat3<double>>& sum,
                         std::vector<Vec3<double>>& rhs) const {
    for (std::size_t n = 0; n < sheet.triangles.size(); ++n) {
      const Index* v = sheet.triangles[n].v;
      std::size_t next = 6 * n;
      for (int i = 0; i < 3; ++i) {
        rhs[static_cast<std::size_t>(v[i])] +=
            vec_cast<double>(impulse[3 * n + static_cast<std::size_t>(i)]);
        for (int j = i; j < 3; ++j) {
          Mat3<double> b{};
          for (int k = 0; k < 9; ++k) b.e[k] = double{block[next].e[k]};
          ++next;
          sum[{v[i], v[j]}] += b;
          if (i != j) sum[{v[j], v[i]}] += transpose(b);
        }
      }
    }
  }
  void scatter_hinges(std::map<std::pair<Index, Index>, Mat3<double>>& sum,
                      std::vector<Vec3<double>>& rhs) const {
    for (std::size_t n = 0; n < sheet.hinges.size(); ++n) {
      const Index* v = sheet.hinges[n].v;
      for (int i = 0; i < 4; ++i) {
        const auto di = vec_cast<double>(direction[4 * n + static_cast<std::size_t>(i)]);
        rhs[static_cast<std::size_t>(v[i])] += double{impulse_scale[n]} * di;
        for (int j = 0; j < 4; ++j) {
          const auto dj = vec_cast<double>(direction[4 * n + static_cast<std::size_t>(j)]);
          sum[{v[i], v[j]}] += double{curvature[n]} * outer(di, dj);
        }
      }
    }
  }
};

using Cases = testing::Types<RowsCase<float, true>, RowsCase<float, false>, RowsCase<double, true>,
                             RowsCase<double, false>>;
INSTANTIATE_TYPED_TEST_SUITE_P(AssembleRows, KernelParity, Cases);

}  // namespace
}  // namespace weft::parity
