#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/base/checksum.hpp"
#include "weft/core/span.hpp"
#include "weft/scene.hpp"

namespace weft {

/// How the time of a recorded motion, a clip, follows from that of the scene.
struct Playback {
  double start_time = 0;  ///< [s] of the scene, at which the clip starts
  double speed = 1;       ///< seconds of the clip a second of the scene, > 0
  bool loop = false;  ///< the clip follows upon itself, at all times; its end jumps to its start
};

/// Adds all that a playback consists of.
void add_to(Checksum& checksum, const Playback& playback);

/// Time within a clip: held at its start before it and at its end after it, unless it loops.
/// @param duration [s] of the clip, >= 0
/// @param time     [s] of the scene
/// @return         [s] from 0 to `duration`
double clip_time(const Playback& playback, double duration, double time);

/// [s] of the scene, at which a clip ends; infinite if it repeats.
double clip_end(const Playback& playback, double duration);

/// Shape given by all positions at several instants. With cubic interpolation, a foot that a frame
/// puts on the floor is not pushed through it by its neighbours, as plain Catmull-Rom would.
///
/// Frames are stored as 32-bit floats, 12 bytes a vertex. Positions that are floats already come
/// back exactly; others within 2^-24 of half the longest side of the frame's own bounding box.
class SampledDeformation : public Deformation {
 public:
  /// Bytes that a sequence of this size takes.
  static double bytes_of(std::size_t vertex_count, std::size_t frame_count) {
    return 12.0 * static_cast<double>(vertex_count) * static_cast<double>(frame_count);
  }

  explicit SampledDeformation(Interpolation interpolation, Playback playback = {})
      : interpolation_(interpolation), playback_(playback) {}

  /// Appends a frame.
  /// @param time      [s] in the clip, from 0 at the first frame on, increasing
  /// @param positions [vertices] [m] finite, as many as in the first frame
  void add_frame(double time, Span<const Vec3<double>> positions);

  std::size_t frame_count() const { return frames_.size(); }
  std::size_t vertex_count() const { return frames_.empty() ? 0 : frames_.front().offsets.size(); }

  /// @pre at least one frame, out.size() == vertex_count()
  void positions(double time, Span<Vec3<double>> out) const override;
  std::uint64_t checksum() const override;
  double last_time() const override {
    return clip_end(playback_, frames_.empty() ? 0 : frames_.back().time);
  }

 private:
  struct Frame {
    double time;
    Vec3<double> centre;
    std::vector<Vec3<float>> offsets;  ///< [vertices] from the centre

    Vec3<double> position(std::size_t v) const { return centre + vec_cast<double>(offsets[v]); }
  };
  void interpolate(std::size_t before, double time, Span<Vec3<double>> out) const;

  Interpolation interpolation_;
  Playback playback_;
  std::vector<Frame> frames_;
};

}  // namespace weft
