#include "weft/state/row_order.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "host/implicit/linear/mesh_rows.hpp"
#include "host/model/model.hpp"
#include "tests/support/small_scenes.hpp"
#include "weft/state/block_ell.hpp"

// Compares slices for CUDA with slices for hosts, which are not sorted.

namespace weft {
namespace {

/// A sheet whose last window is not full.
Scene sheet() {
  Scene scene;
  scene.materials = {test::cotton()};
  scene.materials[0].bending_stiffness = 1e-5;
  scene.cloths.push_back(test::sheet(12, 0));
  return scene;
}

/// Columns of a row, without padding.
std::vector<Index> entries(const std::vector<Offset>& slice_offset,
                           const std::vector<Index>& column, const RowOrder& order, Index slice,
                           Index row) {
  std::vector<Index> found;
  const Index place = order.place(row);
  const auto s = static_cast<std::size_t>(place / slice);
  for (Offset slot = slice_offset[s]; slot < slice_offset[s + 1]; ++slot)
    if (const Index other = column[static_cast<std::size_t>(slot * slice + place % slice)];
        other != row)
      found.push_back(other);
  return found;
}

TEST(RowOrder, KeepsTheEntriesOfEachRow) {
  const Scene scene = sheet();
  const Model model = make_model(scene);
  const Index rows = model.cloth_vertex_count;
  ASSERT_NE(rows % RowOrder::window, 0);
  const Partition host = make_partition(rows, 1, 64),
                  cuda = make_partition(rows, 1, 64, cuda_slice);
  const MeshRows a = make_mesh_rows(model, host, 0), b = make_mesh_rows(model, cuda, 0);
  const std::vector<unsigned char> held(static_cast<std::size_t>(model.cloth_triangle_count), 0);
  const PlateMatrix matrix = make_plate(scene, model, held);
  const PlateRows p = make_plate_rows(matrix, a, host, 0), q = make_plate_rows(matrix, b, cuda, 0);
  EXPECT_TRUE(a.order.empty());
  ASSERT_EQ(b.order.size(), static_cast<std::size_t>(rows));
  const RowOrder none, order{b.order};
  for (Index row = 0; row < rows; ++row) {
    const auto near = entries(a.slice_offset, a.column, none, host_slice, row);
    EXPECT_EQ(near, entries(b.slice_offset, b.column, order, cuda_slice, row));
    EXPECT_EQ(order.entries(order.place(row), 0), static_cast<Index>(near.size()));
    EXPECT_EQ(order.row(order.place(row)), row);
    EXPECT_EQ(entries(p.off_pattern_slice_offset, p.off_pattern_column, none, host_slice, row),
              entries(q.off_pattern_slice_offset, q.off_pattern_column, order, cuda_slice, row));
  }
  // Within a window, rows with more entries come first.
  for (Index place = 1; place < rows; ++place)
    EXPECT_TRUE(place % RowOrder::window == 0 ||
                order.entries(place, 0) <= order.entries(place - 1, 0));
  EXPECT_EQ(p.in_pattern_column, q.in_pattern_column);
  EXPECT_EQ(p.ghost, q.ghost);
}

/// Several threads make the rows of a large rank, one those of each small one.
TEST(RowOrder, LargeRanksHaveTheRowsOfSmallOnes) {
  Scene scene = sheet();
  scene.cloths = {test::sheet(80, 0)};
  const Model model = make_model(scene);
  const Index rows = model.cloth_vertex_count;
  ASSERT_GT(rows, 4096);
  const std::vector<unsigned char> held(static_cast<std::size_t>(model.cloth_triangle_count), 0);
  const PlateMatrix matrix = make_plate(scene, model, held);
  const auto append = [](auto& all, const auto& more) {
    all.insert(all.end(), more.begin(), more.end());
  };
  const auto append_offsets = [](std::vector<Offset>& all, const std::vector<Offset>& more) {
    const Offset base = all.empty() ? 0 : all.back();
    if (!all.empty()) all.pop_back();
    for (const Offset offset : more) all.push_back(base + offset);
  };
  for (const Index slice : {host_slice, cuda_slice}) {
    const Partition one = make_partition(rows, 1, 64, slice),
                    some = make_partition(rows, 4, 64, slice);
    MeshRows mesh;
    PlateRows plate;
    for (int r = 0; r < 4; ++r) {
      const MeshRows part = make_mesh_rows(model, some, r);
      const PlateRows bending = make_plate_rows(matrix, part, some, r);
      append(mesh.order, part.order);
      append(mesh.column, part.column);
      append_offsets(mesh.slice_offset, part.slice_offset);
      append_offsets(mesh.block_source_offset, part.block_source_offset);
      append_offsets(plate.in_pattern_offset, bending.in_pattern_offset);
      append(plate.in_pattern_column, bending.in_pattern_column);
      append(plate.in_pattern_stiffness, bending.in_pattern_stiffness);
      append_offsets(plate.off_pattern_slice_offset, bending.off_pattern_slice_offset);
      append(plate.off_pattern_column, bending.off_pattern_column);
      append(plate.off_pattern_damping, bending.off_pattern_damping);
    }
    const MeshRows all = make_mesh_rows(model, one, 0);
    const PlateRows bending = make_plate_rows(matrix, all, one, 0);
    EXPECT_EQ(all.order, mesh.order);
    EXPECT_EQ(all.column, mesh.column);
    EXPECT_EQ(all.slice_offset, mesh.slice_offset);
    EXPECT_EQ(all.block_source_offset, mesh.block_source_offset);
    EXPECT_EQ(bending.in_pattern_offset, plate.in_pattern_offset);
    EXPECT_EQ(bending.in_pattern_column, plate.in_pattern_column);
    EXPECT_EQ(bending.in_pattern_stiffness, plate.in_pattern_stiffness);
    EXPECT_EQ(bending.off_pattern_slice_offset, plate.off_pattern_slice_offset);
    EXPECT_EQ(bending.off_pattern_column, plate.off_pattern_column);
    EXPECT_EQ(bending.off_pattern_damping, plate.off_pattern_damping);
  }
}

TEST(RowOrder, VeryLongRowsHaveAllSlotsOfTheirSlice) {
  const std::vector<Index> packed = {RowOrder::pack(0, 0, RowOrder::entries_max + 5)};
  EXPECT_EQ(RowOrder{packed}.entries(0, 1'000'000), 1'000'000);
  EXPECT_EQ(RowOrder{packed}.row(0), 0);
  EXPECT_EQ(RowOrder{packed}.place(0), 0);
}

}  // namespace
}  // namespace weft
