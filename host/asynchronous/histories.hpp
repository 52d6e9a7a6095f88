#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "host/asynchronous/chord.hpp"
#include "host/asynchronous/dop.hpp"
#include "host/asynchronous/trajectory.hpp"

namespace weft {

/// The ways of all vertices through one window. Forces of all the cloth give each of its vertices a
/// breakpoint at one time: those stand together, in the order in which they are written. Others
/// give theirs to single vertices.
class Histories {
 public:
  /// Starts over.
  /// @param cloth_count vertices below this have a breakpoint whenever add_all() is called
  void reset(const VertexMotion& motion, std::size_t cloth_count, double time);

  /// All cloth vertices are about to change their velocities.
  /// @param time >= that of any breakpoint
  /// @return [cloth_count] where their positions go. [m]
  Vec3<double>* add_all(double time);

  /// A vertex is about to change its velocity. Cloth has a breakpoint where all of it has; what is
  /// not cloth has none of these but the first.
  void add(std::size_t i, double time, const Vec3<double>& x) {
    const std::size_t last = i < cloth_count_ ? frame_count_ - 1 : 0;
    if (!(time > times_[last])) return;
    std::vector<Breakpoint>& own = own_[i];
    if (own.empty() || time > own.back().t) own.push_back({time, x});
  }

  /// Every way ends here, where the vertices are then.
  void finish(const VertexMotion& motion, double time);

  std::size_t size() const { return own_.size(); }
  std::size_t bytes() const;
  double first_time() const { return times_[0]; }
  double last_time() const { return times_[frame_count_ - 1]; }

  /// [breakpoints] of one vertex, at most
  std::size_t most_breakpoints(std::size_t i) const {
    return std::max<std::size_t>(frame_count_, 2) + own_[i].size();
  }
  /// The way of a vertex, in increasing time.
  /// @param to [most_breakpoints(i)]
  /// @return how many of these have been written
  std::size_t copy(std::size_t i, Breakpoint* to) const;
  std::vector<Breakpoint> way(std::size_t i) const {
    std::vector<Breakpoint> breakpoints(most_breakpoints(i));
    breakpoints.resize(copy(i, breakpoints.data()));
    return breakpoints;
  }

  /// Includes the ways of the vertices first .. last - 1.
  /// @param extents [last - first]
  void include(std::size_t first, std::size_t last, Extent* extents) const;
  /// The chords of the vertices first .. last - 1.
  /// @param chords [last - first]
  void chords(std::size_t first, std::size_t last, Chord* chords) const;

 private:
  std::size_t cloth_count_ = 0;
  std::size_t frame_count_ = 0;                    ///< of frames_ that are in use
  std::vector<double> times_;                      ///< [frames] [s] ascending
  std::vector<std::vector<Vec3<double>>> frames_;  ///< [frames] [cloth_count] [m]
  std::vector<std::vector<Breakpoint>> own_;       ///< [vertices] breakpoints between frames
  std::vector<Vec3<double>> starts_, ends_;        ///< [vertices - cloth_count] [m]
};

}  // namespace weft
