#include "host/simulation/rest_count.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace weft {
namespace {

double last_key(const Motion& motion) {
  return motion.empty() ? 0 : motion.back().time;
}

/// What goes on for ever is no change.
double unless_endless(double time) {
  return std::isfinite(time) ? time : 0;
}

}  // namespace

template <class T>
void RestCount::add_frame(Span<const Vec3<T>> positions, Span<const Vec3<T>> velocities, double end,
                          int frames) {
  if (before_.size() == positions.size() && end > before_time_) {
    if (state_.quiet_frames == 0) since_ = before_;
    const bool quiet = is_quiet(positions, velocities, end - before_time_, frames);
    state_.quiet_frames = quiet && end > last_change_ ? state_.quiet_frames + 1 : 0;
  } else {
    state_ = {};
  }
  state_.rested = state_.quiet_frames >= frames;
  begin_frame(positions, end);
}

/// @param duration [s] of the frame
template <class T>
bool RestCount::is_quiet(Span<const Vec3<T>> positions, Span<const Vec3<T>> velocities,
                         double duration, int frames) {
  const double way = moving_speed * duration;
  std::size_t moving = 0, displaced = 0;
  for (std::size_t v = 0; v < velocities.size(); ++v) {
    const auto x = vec_cast<double>(positions[v]);
    const bool fast = length_sq(vec_cast<double>(velocities[v])) > moving_speed * moving_speed;
    moving += fast && length_sq(x - before_[v]) > way * way ? 1 : 0;
    displaced += length_sq(x - since_[v]) > frames * way * frames * way ? 1 : 0;
  }
  const auto count = static_cast<double>(std::max<std::size_t>(velocities.size(), 1));
  state_.moving_share = static_cast<double>(moving) / count;
  state_.displaced_share = static_cast<double>(displaced) / count;
  return state_.moving_share <= moving_share_max && state_.displaced_share <= displaced_share_max;
}

template <class T>
void RestCount::begin_frame(Span<const Vec3<T>> positions, double time) {
  before_.clear();
  for (const Vec3<T>& x : positions) before_.push_back(vec_cast<double>(x));
  before_time_ = time;
}

QuietFrames RestCount::quiet_frames() const {
  if (state_.quiet_frames == 0) return {};
  return {state_.quiet_frames, since_};
}

void RestCount::restore(QuietFrames quiet, int frames) {
  state_.quiet_frames = quiet.count;
  state_.rested = quiet.count >= frames;
  since_ = std::move(quiet.since);
}

template void RestCount::add_frame(Span<const Vec3<float>>, Span<const Vec3<float>>, double, int);
template void RestCount::add_frame(Span<const Vec3<double>>, Span<const Vec3<double>>, double, int);
template void RestCount::begin_frame(Span<const Vec3<float>>, double);
template void RestCount::begin_frame(Span<const Vec3<double>>, double);

int quiet_frames_of_rest(const TimeSettings& time) {
  return std::max(2, static_cast<int>(std::ceil(quiet_duration * time.frame_rate * (1 - 1e-9))));
}

double last_change(const Scene& scene) {
  double last = 0;
  for (const Obstacle& obstacle : scene.obstacles) {
    last = std::max(last, last_key(obstacle.motion));
    if (obstacle.deformation) last = std::max(last, obstacle.deformation->last_time());
    if (obstacle.driven)
      last =
          std::max({last, obstacle.driven->start_time, unless_endless(obstacle.driven->end_time)});
  }
  for (const Pin& pin : scene.pins)
    last = std::max({last, last_key(pin.motion), unless_endless(pin.release_time)});
  for (const Handle& handle : scene.handles)
    last = std::max({last, last_key(handle.motion), handle.start_time,
                     unless_endless(handle.end_time + handle.fade_time)});
  for (const Seam& seam : scene.seams) last = std::max(last, seam.start_time + seam.ramp_time);
  return last;
}

}  // namespace weft
