#pragma once

#include <cstdint>
#include <vector>

#include "host/scene/model.hpp"
#include "host/scene/partition.hpp"
#include "weft/devices.hpp"
#include "weft/exec/buffer.hpp"
#include "weft/state/contact.hpp"

namespace weft {

/// What one rank holds of the state: a copy of everything. Arrays count cloth first, then obstacle.
template <class T>
struct RankState {
  Buffer<Vec3<T>> positions;            ///< [vertices] [m]
  Buffer<Vec3<T>> velocities;           ///< [cloth vertices] [m/s]
  Buffer<Vec3<T>> previous_positions;   ///< [vertices] one step ago
  Buffer<Vec3<T>> previous_velocities;  ///< [cloth vertices]
  Buffer<unsigned char> touched;        ///< [vertices] moved by an impact zone in the last step
  Buffer<ContactMemory<T>> contacts;    ///< of the last step: those of faces, then those of edges
};

/// The state at rest between steps, as a checkpoint keeps it. Internal order, run precision.
template <class T>
struct StateSnapshot {
  double time = 0;           ///< [s]
  double previous_step = 0;  ///< [s] 0: no history yet
  std::int64_t step_number = 0;
  std::vector<Vec3<T>> positions;
  std::vector<Vec3<T>> velocities;
  std::vector<Vec3<T>> previous_positions;
  std::vector<Vec3<T>> previous_velocities;
  std::vector<unsigned char> touched;
  std::vector<ContactMemory<T>> contacts;
  std::int64_t face_contacts = 0;  ///< how many of `contacts` are of faces
};

/// Owns model and state, and hands out spans of them. Whoever changes topology raises the epoch;
/// whoever keeps something derived from topology compares it first.
template <class T>
class Store {
 public:
  /// @param welded see make_model
  Store(const Scene& scene, DeviceSet& devices, const std::vector<unsigned char>& welded = {});

  const Scene& scene() const noexcept { return *scene_; }
  DeviceSet& devices() const noexcept { return *devices_; }
  const Model& model() const noexcept { return model_; }
  const Partition& partition() const noexcept { return partition_; }
  std::uint64_t epoch() const noexcept { return epoch_; }
  RankState<T>& rank(int r) noexcept { return ranks_[static_cast<std::size_t>(r)]; }

  double time = 0;           ///< [s]
  double previous_step = 0;  ///< [s] length of the last accepted step, 0: none
  std::int64_t step_number = 0;
  std::int64_t face_contacts = 0;  ///< of RankState::contacts

  /// Reads the state back from rank 0; all ranks hold the same bits.
  /// @pre no work is under way
  StateSnapshot<T> snapshot() const;
  /// Gives every rank the state of `s`.
  void restore(const StateSnapshot<T>& s);

 private:
  const Scene* scene_;
  DeviceSet* devices_;
  Model model_;
  Partition partition_;
  std::uint64_t epoch_ = 1;
  std::vector<RankState<T>> ranks_;
};

/// Copies `from` into a buffer of the queue's device, and waits for it.
template <class T>
void upload(Queue& queue, Buffer<T>& to, const std::vector<T>& from) {
  to.resize(from.size());
  queue.copy(to.data(), from.data(), from.size() * sizeof(T));
  queue.sync();
}

template <class T>
std::vector<T> download(Queue& queue, const Buffer<T>& from) {
  std::vector<T> to(from.size());
  queue.copy(to.data(), from.data(), from.size() * sizeof(T));
  queue.sync();
  return to;
}

/// The same numbers in another precision.
template <class To, class From>
std::vector<To> cast_all(const std::vector<From>& from) {
  std::vector<To> to(from.size());
  for (std::size_t i = 0; i < from.size(); ++i) to[i] = static_cast<To>(from[i]);
  return to;
}
template <class To, class From, int N>
std::vector<Vec<To, N>> cast_all(const std::vector<Vec<From, N>>& from) {
  std::vector<Vec<To, N>> to(from.size());
  for (std::size_t i = 0; i < from.size(); ++i) to[i] = vec_cast<To>(from[i]);
  return to;
}

}  // namespace weft
