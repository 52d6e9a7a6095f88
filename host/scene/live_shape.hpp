#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "weft/core/span.hpp"
#include "weft/scene.hpp"

namespace weft {

/// Places of vertices that a program moves: on straight lines, from where they are at the start of
/// a frame to their targets at its end. World places.
class LiveShape : public Deformation {
 public:
  /// What a checkpoint keeps of it.
  struct State {
    std::vector<Vec3<double>> from, to;  ///< [vertices] [m] at `start` and at `end`
    /// [vertices] [m] at the end of the next frame; empty: it rests at `to`
    std::vector<Vec3<double>> next{};
    double start = 0, end = 0;  ///< [s]
    bool moved = false;         ///< whether it has ever been given targets
  };

  explicit LiveShape(const std::vector<Vec3<double>>& places) : state_{places, places} {}

  std::size_t size() const { return state_.to.size(); }
  /// Targets for the end of the next frame.
  /// @param places [vertices] [m]
  void move(Span<const Vec3<double>> places);
  /// Begins a frame: targets that have been set are reached at its end.
  /// @param start [s]   @param end [s]
  void begin_frame(double start, double end);

  Vec3<double> at(double time, std::size_t vertex) const;
  void positions(double time, Span<Vec3<double>> out) const override;
  /// That of no place: checkpoints keep the state instead.
  std::uint64_t checksum() const override { return 0; }

  const State& state() const { return state_; }
  /// @pre of as many vertices
  void restore(State state) { state_ = std::move(state); }

 private:
  State state_;
};

}  // namespace weft
