#include "host/simulation/frame_clock.hpp"

#include <algorithm>
#include <cmath>

#include "host/input/checker.hpp"
#include "host/scene/frame_steps.hpp"
#include "weft/error.hpp"

namespace weft {
namespace {

/// Most steps of one frame of the program's.
constexpr double most_steps = 1e6;

}  // namespace

FrameClock::FrameClock(const Scene& scene) : time_(scene.time), file_(scene.file) {
  if (time_.automatic)
    control_.emplace(time_, scene.integrator);
  else
    steps_per_frame_ = frame_steps(time_);
}

double FrameClock::step_length(double now, double next) const {
  return automatic() ? control_->next(next, now).length : frame_step_length(time_);
}

FrameClock::FixedStep FrameClock::next_fixed(std::int64_t number, double now) const {
  if (has_own_steps()) {
    const double end =
        frame_->start + static_cast<double>(number - frame_->start_step) * frame_->length;
    return {frame_->length, number == frame_->end_step ? frame_->end : end};
  }
  const double length = frame_step_length(time_);
  return {length, counts(now, number - 1) ? static_cast<double>(number) * length : now + length};
}

double FrameClock::latest_end(std::int64_t number, double now, double next) const {
  return automatic() ? control_->next(next, now).end : next_fixed(number, now).end;
}

bool FrameClock::counts(double now, std::int64_t steps) const {
  return automatic() || now == static_cast<double>(steps) * frame_step_length(time_);
}

bool FrameClock::at_frame_end(double now, std::int64_t steps) const {
  if (automatic()) return control_->at_frame_end(now);
  if (counts(now, steps) && !has_own_steps()) return steps % steps_per_frame_ == 0;
  return !frame_ || steps >= frame_->end_step;
}

int FrameClock::frame_number(double now, std::int64_t steps) const {
  if (automatic()) return control_->frames(now);
  if (counts(now, steps)) return static_cast<int>(steps / steps_per_frame_);
  return static_cast<int>(std::floor(now * time_.frame_rate * (1 + 1e-12)));
}

double FrameClock::begin_program_frame(double seconds, double now, std::int64_t steps) {
  const double unit = automatic() ? 1 / time_.frame_rate : frame_step_length(time_);
  const double count = std::round(seconds / unit);
  const bool whole = std::abs(seconds - count * unit) <= 1e-6 * unit && count >= 1;
  if (!(seconds >= quantity::step.least && seconds <= most_steps * unit) || (automatic() && !whole))
    throw SceneError(file_, "advance", text_of(seconds) + " s",
                     automatic()
                         ? "a whole number of frames of " + text_of(unit) + " s, at least one"
                         : "a time from 1e-9 s to that of a million steps");
  if (automatic()) {
    const int frames = control_->frames(now) + static_cast<int>(count);
    frame_ = {now, frame_time(time_, frames), 0, 0, 0};
  } else if (whole && counts(now, steps)) {
    const std::int64_t last = steps + static_cast<std::int64_t>(count);
    frame_ = {now, static_cast<double>(last) * unit, steps, last, 0};
  } else {
    // Steps of one length, no longer than the scene's.
    const double own = std::max(1.0, std::ceil(seconds / unit * (1 - 1e-9)));
    frame_ = {now, now + seconds, steps, steps + static_cast<std::int64_t>(own), seconds / own};
  }
  return frame_->end;
}

bool FrameClock::program_frame_ended(double now, std::int64_t steps) const {
  return automatic() ? now >= frame_->end : steps >= frame_->end_step;
}

FrameClock::Counted FrameClock::renumbered(double now, std::int64_t steps,
                                           const std::string& file) const {
  if (automatic()) {
    // Frames are those of the scene, to the bit.
    const double end = frame_time(time_, control_->frames(now));
    return {std::abs(now - end) <= 1e-9 / time_.frame_rate ? end : now, steps};
  }
  const double length = frame_step_length(time_);
  const auto number = std::llround(now / length);
  if (number != steps && !(std::abs(static_cast<double>(number) * length - now) <= 1e-9 * length))
    throw SceneError(file, "checkpoint time", text_of(now) + " s",
                     "the end of a step of " + text_of(length) + " s");
  return {now, number};
}

void FrameClock::pack(Packer& packer, bool counted) const {
  packer.put(frame_.value_or(ProgramFrame{}));
  packer.put(static_cast<unsigned char>(frame_ ? 1 : 0));
  packer.put(static_cast<unsigned char>(counted ? 1 : 0));
}

bool FrameClock::unpack(Unpacker& unpacker) {
  ProgramFrame read;
  unsigned char interrupted = 0, counted = 0;
  unpacker.get(read);
  unpacker.get(interrupted);
  unpacker.get(counted);
  if (interrupted > 1 || counted > 1 || !std::isfinite(read.start + read.end + read.length) ||
      read.length < 0 || read.start_step < 0 || read.end_step < read.start_step)
    unpacker.refuse("has values that cannot be");
  frame_.reset();
  if (interrupted != 0) frame_ = read;
  return counted != 0;
}

}  // namespace weft
