#include "host/model/deformation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/geometry/aabb.hpp"
#include "host/geometry/local_origin.hpp"
#include "host/scene/key_slope.hpp"
#include "weft/core/assert.hpp"

namespace weft {
namespace {

bool is_float(const Vec3<double>& x) {
  for (int k = 0; k < 3; ++k)
    if (static_cast<double>(static_cast<float>(x[k])) != x[k]) return false;
  return true;
}

}  // namespace

void add_to(Checksum& checksum, const Playback& playback) {
  checksum.add(playback.start_time);
  checksum.add(playback.speed);
  checksum.add(static_cast<int>(playback.loop));
}

std::uint64_t SampledDeformation::checksum() const {
  Checksum checksum;
  checksum.add(static_cast<int>(interpolation_));
  add_to(checksum, playback_);
  for (const Frame& frame : frames_) {
    checksum.add(frame.time);
    checksum.add(frame.centre.e, sizeof frame.centre.e);
    checksum.add(frame.offsets);
  }
  return checksum.value();
}

double clip_time(const Playback& playback, double duration, double time) {
  const double t = (time - playback.start_time) * playback.speed;
  if (!playback.loop || !(duration > 0)) return std::clamp(t, 0.0, duration);
  const double rest = std::fmod(t, duration);
  return rest < 0 ? rest + duration : rest;
}

double clip_end(const Playback& playback, double duration) {
  if (!(duration > 0)) return 0;
  if (playback.loop) return std::numeric_limits<double>::infinity();
  return playback.start_time + duration / playback.speed;
}

void SampledDeformation::add_frame(double time, Span<const Vec3<double>> positions) {
  WEFT_ASSERT(frames_.empty() ? time == 0 : time > frames_.back().time);
  WEFT_ASSERT(frames_.empty() || positions.size() == vertex_count());
  Frame frame{time, {0, 0, 0}, {}};
  if (!positions.empty() && !std::all_of(positions.begin(), positions.end(), is_float)) {
    const std::vector<Vec3<double>> all(positions.begin(), positions.end());
    frame.centre = aabb_of(all).center();
    // Floats that were moved far away come back exactly if they are moved back.
    const Vec3<double> origin = local_origin({&all});
    if (origin != Vec3<double>{0, 0, 0} && std::all_of(all.begin(), all.end(), [&](const auto& x) {
          return is_float(x - origin) && (x - origin) + origin == x;
        }))
      frame.centre = origin;
  }
  frame.offsets.reserve(positions.size());
  for (const Vec3<double>& x : positions)
    frame.offsets.push_back(vec_cast<float>(x - frame.centre));
  frames_.push_back(std::move(frame));
}

void SampledDeformation::positions(double time, Span<Vec3<double>> out) const {
  WEFT_ASSERT(!frames_.empty() && out.size() == vertex_count());
  const double t = clip_time(playback_, frames_.back().time, time);
  const auto next = std::upper_bound(frames_.begin(), frames_.end(), t,
                                     [](double at, const Frame& f) { return at < f.time; });
  const auto before = static_cast<std::size_t>(next - frames_.begin()) - 1;
  if (before + 1 == frames_.size() || t == frames_[before].time) {
    for (std::size_t v = 0; v < out.size(); ++v) out[v] = frames_[before].position(v);
    return;
  }
  interpolate(before, t, out);
}

void SampledDeformation::interpolate(std::size_t before, double time,
                                     Span<Vec3<double>> out) const {
  const Frame& f0 = frames_[before];
  const Frame& f1 = frames_[before + 1];
  const double span = f1.time - f0.time;
  const double s = (time - f0.time) / span;
  if (interpolation_ == Interpolation::linear) {
    for (std::size_t v = 0; v < out.size(); ++v)
      out[v] = f0.position(v) + (f1.position(v) - f0.position(v)) * s;
    return;
  }
  const Frame* earlier = before > 0 ? &frames_[before - 1] : nullptr;
  const Frame* later = before + 2 < frames_.size() ? &frames_[before + 2] : nullptr;
  const double s2 = s * s;
  const double s3 = s2 * s;
  const double share = 3 * s2 - 2 * s3;
  const double share_m0 = (s3 - 2 * s2 + s) * span;
  const double share_m1 = (s3 - s2) * span;
  for (std::size_t v = 0; v < out.size(); ++v) {
    const Vec3<double> x0 = f0.position(v);
    const Vec3<double> x1 = f1.position(v);
    const Vec3<double> chord = (x1 - x0) * (1 / span);
    // At the ends of the recording, whose motion goes on there for all one knows: as the chord.
    Vec3<double> m0 = chord;
    Vec3<double> m1 = chord;
    if (earlier) {
      const Vec3<double> x = earlier->position(v);
      for (int k = 0; k < 3; ++k)
        m0[k] = limited_slope((x0[k] - x[k]) / (f0.time - earlier->time), chord[k],
                              (x1[k] - x[k]) / (f1.time - earlier->time));
    }
    if (later) {
      const Vec3<double> x = later->position(v);
      for (int k = 0; k < 3; ++k)
        m1[k] = limited_slope(chord[k], (x[k] - x1[k]) / (later->time - f1.time),
                              (x[k] - x0[k]) / (later->time - f0.time));
    }
    out[v] = x0 + (x1 - x0) * share + m0 * share_m0 + m1 * share_m1;
  }
}

}  // namespace weft
