#include "host/simulation/step_control.hpp"

#include <algorithm>
#include <cmath>

#include "host/scene/frame_steps.hpp"

namespace weft {
namespace {

/// Share of a frame that the first step takes.
constexpr double first_share = 1.0 / 8;
/// What a step aims at is a little below the tolerance, so that most are not rejected.
constexpr double safety = 0.9;

}  // namespace

StepControl::StepControl(const TimeSettings& time, Integrator integrator)
    : time_(time), frame_(1 / time.frame_rate), order_(integrator == Integrator::bdf2 ? 3 : 2) {}

int StepControl::frames(double now) const {
  // A frame has at most 10,000 steps, so only its end is this near.
  return static_cast<int>(std::floor(now * time_.frame_rate + 1e-6));
}

bool StepControl::at_frame_end(double now) const {
  return now == frame_time(time_, frames(now));
}

StepControl::Step StepControl::next(double length, double now) const {
  const double end = frame_time(time_, frames(now) + 1);
  const double rest = end - now;
  const double wanted = std::clamp(length > 0 ? length : first_share * frame_, shortest(), frame_);
  // A remainder that takes a hair more than a whole number of steps takes that number.
  const double count = std::max(1.0, std::ceil(rest / wanted * (1 - 1e-9)));
  if (count == 1) return {rest, end, true};
  return {rest / count, now + rest / count, false};
}

bool StepControl::rejects(const Step& step, double error, int rejections) const {
  return error > rejected_error && rejections < rejections_max &&
         step.length > (1 + 1e-9) * shortest();
}

/// [s] Twice the shortest step: the remainder of a frame is divided evenly.
double StepControl::shortest() const {
  return 2 * frame_ / automatic_frame_steps_max;
}

/// By which the step would have met its tolerance.
double StepControl::factor(double error) const {
  const double most = growth_max;
  return std::clamp(error > 0 ? safety * std::pow(error, -1 / order_) : most, 1 / shrinkage_max,
                    most);
}

double StepControl::again(const Step& step, double error) const {
  return std::min(0.5, factor(error)) * step.length;
}

double StepControl::after(const Step& step, double error, bool may_grow) const {
  return std::min(may_grow ? growth_max : 1.0, factor(error)) * step.length;
}

}  // namespace weft
