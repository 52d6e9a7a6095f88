#pragma once

#include <vector>

#include "host/model/model.hpp"
#include "host/state/partition.hpp"
#include "weft/kernels/assemble/rows.hpp"

namespace weft {

/// Mesh data that one rank assembles: the elements that touch its rows (P-Cloth section 3.2.1), the
/// fixed sparsity pattern of its matrix off the diagonal, and the table by which each entry gathers
/// its element blocks.
struct MeshRows {
  std::vector<Index> triangles;  ///< numbers in Model, ascending
  std::vector<Index> hinges;
  std::vector<Index> order;          ///< see RowOrder
  std::vector<Offset> slice_offset;  ///< see BlockEll
  std::vector<Index> column;
  std::vector<Offset> block_source_offset;  ///< see AssembleRows
  std::vector<BlockSource> block_source;
  std::vector<Offset> corner_source_offset;
  std::vector<Index> corner_source;
  std::vector<Index> ghost;  ///< columns of other ranks, ascending
};

MeshRows make_mesh_rows(const Model& model, const Partition& partition, int rank);

/// Slots of the slice of each row of a matrix, see BlockEll. [rows]
std::vector<double> slots_of_rows(const std::vector<Offset>& slice_offset, const RowOrder& order,
                                  Index slice, std::size_t rows);

/// The rows of the plate matrix that one rank owns, see AssemblePlate.
struct PlateRows {
  std::vector<Offset> in_pattern_offset, in_pattern_place;
  std::vector<Index> in_pattern_column;
  std::vector<double> in_pattern_stiffness, in_pattern_damping;
  std::vector<Offset> off_pattern_slice_offset;
  std::vector<Index> off_pattern_column;
  std::vector<double> off_pattern_stiffness, off_pattern_damping;
  std::vector<Index> ghost;  ///< columns of other ranks, here or in the mesh matrix, ascending
};

/// @param mesh of the same rank; entries that it has too are "in the pattern", see the glossary
PlateRows make_plate_rows(const PlateMatrix& matrix, const MeshRows& mesh,
                          const Partition& partition, int rank);

}  // namespace weft
