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

/// Steps that begin in two halves because the solve of a whole one did not converge: what follows
/// would most likely fail alike, and cost as much. After each further such attempt there are twice
/// as many, up to run_max; once a whole step converges, none.
struct Backoff {
  std::int32_t left = 0;  ///< yet to begin so
  std::int32_t run = 0;   ///< after the latest attempt that did not converge
  static constexpr std::int32_t run_max = 16;

  /// After an attempt that did not converge.
  void begin_run() { left = run = std::min(run_max, std::max(1, 2 * run)); }
};

/// The state at rest between steps, as a checkpoint keeps it. Internal order, run precision.
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
  /// [driven obstacles, 3 each] angle [rad], speed [rad/s], angular impulse not yet taken [N m s]
  std::vector<double> driven{};
  SleepState<T> sleep{};
};

/// Owns model and state, and hands out spans of them. Whoever changes topology raises the epoch;
/// whoever keeps something derived from topology compares it first.
template <class T>
class Store {
 public:
  /// @param welded see make_model
  /// @param before of the same scene, whose meshes were others: the time and the laws of materials
  ///               are its; null: none
  Store(const Scene& scene, DeviceSet& devices, const std::vector<unsigned char>& welded = {},
        const Store* before = nullptr);
  /// Of a model that has been made already, at rest where it starts.
  Store(const Scene& scene, DeviceSet& devices, Model model);

  const Scene& scene() const noexcept { return *scene_; }
  DeviceSet& devices() const noexcept { return *devices_; }
  const Model& model() const noexcept { return model_; }
  const Partition& partition() const noexcept { return partition_; }
  std::uint64_t epoch() const noexcept { return epoch_; }
  /// Gives the ranks other rows. Whoever keeps something of a rank's rows makes it anew; the state
  /// does not depend on it.
  /// @param row_begin as in Partition
  void share_rows(std::vector<Index> row_begin);
  RankState<T>& rank(int r) noexcept { return ranks_[static_cast<std::size_t>(r)]; }

  /// Bending as a plate while the vertices are held that `fixed` says: the matrix of the last call
  /// if the same triangles cannot bend, another one otherwise.
  /// @param fixed [>= cloth vertices] 1: its position is prescribed
  /// @return      never null; empty where bending goes by hinges
  std::shared_ptr<const PlateMatrix> plate(const std::vector<unsigned char>& fixed);

  /// How much of a compression the cloth's material sees, see buckling.hpp.
  /// @param by_input [cloth triangles] as the scene numbers them, 0 to 1; empty: 1
  void set_compression(const std::vector<double>& by_input);
  /// Another one after each change of the model's `compression`.
  std::uint64_t compression_epoch() const noexcept { return compression_epoch_; }

  double time = 0;           ///< [s]
  double previous_step = 0;  ///< [s] length of the last accepted step, 0: none
  std::int64_t step_number = 0;
  Backoff backoff;
  std::int64_t face_contacts = 0;  ///< of RankState::contacts
  std::vector<double> driven;      ///< as in StateSnapshot
  SleepState<T> sleep;

  /// Reads the state back from rank 0; all ranks hold the same bits.
  /// @pre no work is under way
  StateSnapshot<T> snapshot() const;
  /// Gives every rank the state of `s`.
  void restore(const StateSnapshot<T>& s);
  /// Keeps a copy of the state, but for `driven` and `sleep`, on the devices.
  void keep();
  /// Makes the state what it was at the last keep().
  void go_back();
  /// How often the state has been replaced: what was taken from the one before has to be taken
  /// again.
  std::int64_t restores() const noexcept { return restores_; }

 private:
  const Scene* scene_;
  DeviceSet* devices_;
  Model model_;
  Partition partition_;
  std::uint64_t epoch_ = 1;
  std::uint64_t compression_epoch_ = 0;
  std::int64_t restores_ = 0;
  std::vector<unsigned char> held_;           ///< [cloth triangles] those that plate_ is for
  std::shared_ptr<const PlateMatrix> plate_;  ///< null: none asked for yet
  std::vector<RankState<T>> ranks_;
  /// What keep() has kept.
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
