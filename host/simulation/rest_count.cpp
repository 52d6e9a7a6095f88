#include "host/simulation/rest_count.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

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
void RestCount::add_frame(Span<const Vec3<T>> velocities, double end, int frames,
                          Span<const Vec3<T>> positions) {
  const bool known = !positions.empty() && before_.size() == positions.size() && end > before_time_;
  const double way = moving_speed * (end - before_time_);
  std::size_t moving = 0;
  for (std::size_t v = 0; v < velocities.size(); ++v) {
    if (!(length_sq(vec_cast<double>(velocities[v])) > moving_speed * moving_speed)) continue;
    // Jammed cloth trembles without going anywhere.
    if (known && !(length_sq(vec_cast<double>(positions[v]) - before_[v]) > way * way)) continue;
    ++moving;
  }
  const auto count = static_cast<double>(std::max<std::size_t>(velocities.size(), 1));
  state_.moving_share = static_cast<double>(moving) / count;
  const bool quiet = state_.moving_share <= moving_share_max && end > last_change_;
  state_.quiet_frames = quiet ? state_.quiet_frames + 1 : 0;
  state_.rested = state_.quiet_frames >= frames;
  begin_frame(positions, end);
}

template <class T>
void RestCount::begin_frame(Span<const Vec3<T>> positions, double time) {
  before_.clear();
  for (const Vec3<T>& x : positions) before_.push_back(vec_cast<double>(x));
  before_time_ = time;
}

template void RestCount::add_frame(Span<const Vec3<float>>, double, int, Span<const Vec3<float>>);
template void RestCount::add_frame(Span<const Vec3<double>>, double, int, Span<const Vec3<double>>);
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
