#pragma once

#include <vector>

#include "host/state/partition.hpp"
#include "weft/exec/buffer.hpp"
#include "weft/exec/device.hpp"

namespace weft {

/// Whether every rank reads and writes the memory of all others as fast as its own.
inline bool share_memory(const DeviceSet& devices) {
  return devices.backend() == Backend::host;
}

/// Later compute work of every rank starts after the earlier compute work of all ranks.
inline void join_ranks(DeviceSet& devices) {
  if (devices.size() == 1) return;
  std::vector<Event> done;
  for (int r = 0; r < devices.size(); ++r) done.push_back(devices[r].compute().record());
  for (int r = 0; r < devices.size(); ++r)
    for (int s = 0; s < devices.size(); ++s)
      if (s != r) devices[r].compute().wait(done[static_cast<std::size_t>(s)]);
}

inline void sync_ranks(DeviceSet& devices) {
  for (int r = 0; r < devices.size(); ++r) devices[r].compute().sync();
}

/// A piece that rank `from` has and all others want, in elements of the array.
struct GatherPiece {
  std::size_t begin = 0;  ///< where it stands in every rank's copy
  std::size_t count = 0;
};

/// Every rank's piece goes to the same place in every other rank's array. `source(r)` points to the
/// piece in rank r's memory, `target(r)` to the beginning of rank r's array.
/// Runs on the transfer queues, after all compute work so far and before all later compute work.
template <class Source, class Target>
void all_gather(DeviceSet& devices, const std::vector<GatherPiece>& pieces,
                std::size_t element_bytes, Source source, Target target, bool keep_own = true) {
  const int ranks = devices.size();
  if (ranks == 1 && keep_own) return;
  std::vector<Event> computed;
  for (int r = 0; r < ranks; ++r) computed.push_back(devices[r].compute().record());
  std::vector<Event> copied;
  for (int r = 0; r < ranks; ++r) {
    Queue& queue = devices[r].transfer();
    for (const Event& e : computed) queue.wait(e);
    for (int s = 0; s < ranks; ++s) {
      if (s == r && keep_own) continue;
      const GatherPiece& piece = pieces[static_cast<std::size_t>(s)];
      queue.copy(static_cast<char*>(static_cast<void*>(target(r))) + piece.begin * element_bytes,
                 source(s), piece.count * element_bytes);
    }
    copied.push_back(queue.record());
  }
  for (int r = 0; r < ranks; ++r)
    for (const Event& e : copied) devices[r].compute().wait(e);
}

/// Every rank's own rows of an array of vectors go to all other ranks.
template <class T, class Array>
void all_gather_rows(DeviceSet& devices, const Partition& partition, Array array) {
  std::vector<GatherPiece> pieces;
  for (int r = 0; r < partition.ranks(); ++r) {
    const auto begin = static_cast<std::size_t>(partition.row_begin[static_cast<std::size_t>(r)]);
    const auto end = static_cast<std::size_t>(partition.row_begin[static_cast<std::size_t>(r) + 1]);
    pieces.push_back({begin, end - begin});
  }
  all_gather(
      devices, pieces, sizeof(T),
      [&](int r) { return array(r).data() + pieces[static_cast<std::size_t>(r)].begin; },
      [&](int r) { return array(r).data(); });
}

}  // namespace weft
