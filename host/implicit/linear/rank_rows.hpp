#pragma once

#include "host/state/store.hpp"
#include "weft/state/block_ell.hpp"
#include "weft/state/row_blocks.hpp"

namespace weft {

/// The rows of the system that a rank owns.
struct RankRows {
  Index begin = 0;  ///< vertex of the first one
  Index count = 0;
  Index slice = 1;  ///< rows of a slice of the matrices, see BlockEll

  RankRows() = default;
  RankRows(const Partition& partition, int r)
      : begin(partition.row_begin[static_cast<std::size_t>(r)]),
        count(partition.row_begin[static_cast<std::size_t>(r) + 1] - begin),
        slice(partition.slice) {}

  /// See RowBlocks.
  Index block_slice() const { return slice == cuda_slice ? cuda_slice : 1; }
  std::size_t block_numbers() const { return RowBlocks<float>::size(count, block_slice()); }
};

/// A new buffer on the device with these values.
template <class Buffer, class Values>
void put(Device& device, Buffer& buffer, const Values& values) {
  buffer = Buffer(device);
  upload(device.compute(), buffer, values);
}

/// A new buffer on the device, of this size.
template <class Buffer>
void make(Device& device, Buffer& buffer, std::size_t size) {
  buffer = Buffer(device, size);
}

}  // namespace weft
