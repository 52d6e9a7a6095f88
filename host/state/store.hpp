#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

#include "host/model/model.hpp"
#include "host/state/partition.hpp"
#include "host/state/sleep_state.hpp"
#include "weft/devices.hpp"
#include "weft/exec/buffer.hpp"
#include "weft/state/contact.hpp"

namespace weft {

/// The copy of the state that one rank holds. Arrays list cloth first, then obstacles.
template <class T>
struct RankState {
  Buffer<Vec3<T>> positions;            ///< [vertices] [m]
  Buffer<Vec3<T>> velocities;           ///< [cloth vertices] [m/s]
  Buffer<Vec3<T>> previous_positions;   ///< [vertices] one step ago
  Buffer<Vec3<T>> previous_velocities;  ///< [cloth vertices]
  Buffer<unsigned char> touched;        ///< [vertices] by impact zones, see state/touched.hpp
  Buffer<ContactMemory<T>> contacts;    ///< contact cache: face pairs, then edge pairs
  Buffer<Vec3<T>> accelerations;        ///< [cloth vertices] see Store::accelerations()
};

/// Steps that begin bisected because the solve of a whole step did not converge: the next whole
/// steps would most likely fail too, at the same cost. Each further failure doubles their number,
/// up to run_max. Once a whole step converges, the number is 0 again.
struct Backoff {
  std::int32_t left = 0;  ///< steps that are still to begin bisected
  std::int32_t run = 0;   ///< their number after the latest failure
  /// Truncated steps in a row, up to the latest one. Impact zones get less work after many.
  std::int32_t truncated = 0;
  /// Steps that impact zones may still stretch, or that may exceed strain limits: the shortest
  /// parts of a step have not avoided it.
  std::int32_t stretched = 0;
  static constexpr std::int32_t run_max = 16;
  static constexpr std::int32_t stretched_max = 4;

  /// After an attempt that did not converge.
  void begin_run() { left = run = std::min(run_max, std::max(1, 2 * run)); }

  bool operator==(const Backoff&) const = default;
};

/// The state between two steps, as a checkpoint stores it. Internal order, run precision.
template <class T>
struct StateSnapshot {
  double time = 0;           ///< [s]
  double previous_step = 0;  ///< [s] 0: no history yet
  std::int64_t step_number = 0;
  Backoff backoff{};
  std::vector<Vec3<T>> positions;
  std::vector<Vec3<T>> velocities;
  std::vector<Vec3<T>> previous_positions;
  std::vector<Vec3<T>> previous_velocities;
  std::vector<unsigned char> touched;
  std::vector<ContactMemory<T>> contacts;
  std::int64_t face_contacts = 0;  ///< how many of `contacts` are of faces
  /// [driven obstacles, 3 each] angle [rad], speed [rad/s], angular impulse not yet applied [N m s]
  std::vector<double> driven{};
  SleepState<T> sleep{};
  double next_step = 0;  ///< [s] that an automatic step may have; 0: none yet, or fixed steps
};

/// Owns model and state. Code that caches data derived from the topology compares the epoch.
template <class T>
class Store {
 public:
  /// @param welded see make_model
  /// @param before store of the same scene with other meshes; this one takes over its time and
  ///               material laws; null: none
  Store(const Scene& scene, DeviceSet& devices, const std::vector<unsigned char>& welded = {},
        const Store* before = nullptr);
  /// For a model that exists already, in its initial state.
  Store(const Scene& scene, DeviceSet& devices, Model model);

  const Scene& scene() const noexcept { return *scene_; }
  DeviceSet& devices() const noexcept { return *devices_; }
  const Model& model() const noexcept { return model_; }
  const Partition& partition() const noexcept { return partition_; }
  std::uint64_t epoch() const noexcept { return epoch_; }
  /// Changes which rows the ranks own. The state does not change. The caller rebuilds everything
  /// that depends on the rows of a rank.
  /// @param row_begin as in Partition
  void share_rows(std::vector<Index> row_begin);
  RankState<T>& rank(int r) noexcept { return ranks_[static_cast<std::size_t>(r)]; }

  /// Matrix of plate bending while some vertices are held. If the same triangles are held as in the
  /// last call, this is the matrix of that call.
  /// @param fixed [>= cloth vertices] 1: its position is prescribed
  /// @return      never null; empty if bending is by hinges
  std::shared_ptr<const PlateMatrix> plate(const std::vector<unsigned char>& fixed);

  /// Sets the share of a compression that the material resists, see buckling.hpp.
  /// @param by_input [cloth triangles] in the order of the scene, 0 to 1; empty: all 1
  void set_compression(const std::vector<double>& by_input);
  /// Sets constant forces on the cloth from now on.
  /// @param forces [inputs] [N] those of inputs that are one vertex add up; empty: none
  void apply_forces(const std::vector<Vec3<double>>& forces);
  /// [cloth vertices] [m/s^2] these forces over the vertices' masses; empty: none
  const std::vector<Vec3<double>>& accelerations() const noexcept { return accelerations_; }
  /// Changes with the model's `compression`.
  std::uint64_t compression_epoch() const noexcept { return compression_epoch_; }

  double time = 0;           ///< [s]
  double previous_step = 0;  ///< [s] length of the last accepted step, 0: none
  std::int64_t step_number = 0;
  Backoff backoff;
  std::int64_t face_contacts = 0;  ///< entries of RankState::contacts that are of faces
  std::vector<double> driven;      ///< as in StateSnapshot
  SleepState<T> sleep;
  double next_step = 0;  ///< [s] as in StateSnapshot

  /// Reads the state back from rank 0; all ranks hold the same bits.
  /// @pre no work is under way
  StateSnapshot<T> snapshot() const;
  /// Gives every rank the state of `s`.
  void restore(const StateSnapshot<T>& s);
  /// Copies the state, except `driven`, `sleep` and `next_step`, on the devices for go_back().
  /// There is one copy: ImplicitStep keeps the start of a step once more before it halves. Until
  /// then only `backoff` has changed, which Run::step_automatic puts back by itself.
  void keep();
  /// Restores the state of the last keep().
  void go_back();
  /// How often the state has been replaced. If this changed, everything derived from the old state
  /// is out of date.
  std::int64_t restores() const noexcept { return restores_; }

 private:
  const Scene* scene_;
  DeviceSet* devices_;
  Model model_;
  Partition partition_;
  std::uint64_t epoch_ = 1;
  std::uint64_t compression_epoch_ = 0;
  std::int64_t restores_ = 0;
  std::vector<Vec3<double>> accelerations_;
  std::vector<unsigned char> held_;           ///< [cloth triangles] 1: held when plate_ was made
  std::shared_ptr<const PlateMatrix> plate_;  ///< null: not made yet
  std::vector<RankState<T>> ranks_;
  /// The copy that keep() makes.
  struct Kept {
    double time = 0, previous_step = 0;
    std::int64_t step_number = 0;
    Backoff backoff;
    std::int64_t face_contacts = 0;
    std::vector<RankState<T>> ranks;
  };
  Kept kept_;
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

/// Converts numbers to another precision.
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
template <class To>
std::vector<Mat2<To>> cast_all(const std::vector<Mat2<double>>& from) {
  std::vector<Mat2<To>> to;
  to.reserve(from.size());
  for (const Mat2<double>& m : from)
    to.push_back({{static_cast<To>(m.e[0]), static_cast<To>(m.e[1]), static_cast<To>(m.e[2]),
                   static_cast<To>(m.e[3])}});
  return to;
}

}  // namespace weft
