#include "weft/step_progress.hpp"

#include <cmath>

namespace weft {
namespace {

std::string percent(double share) {
  return std::to_string(std::lround(100 * share)) + "%";
}

/// "halved 1/4 at 50%"; empty for a step in one piece.
std::string level_text(const StepProgress& p) {
  if (p.fallback_level == FallbackLevel::whole) return "";
  std::string text = std::string("  ") + describe(p.fallback_level);
  if (p.substep < 1)
    text += " 1/" + std::to_string(std::lround(1 / p.substep)) + " at " + percent(p.done);
  return text;
}

}  // namespace

const char* describe(StepStage stage) {
  switch (stage) {
    case StepStage::none:
      return "none";
    case StepStage::prediction:
      return "prediction";
    case StepStage::contacts:
      return "contacts";
    case StepStage::solve:
      return "solve";
    case StepStage::detection:
      return "detection";
    case StepStage::zones:
      return "impact zones";
    case StepStage::truncation:
      return "truncation";
    case StepStage::remeshing:
      return "remeshing";
    case StepStage::windows:
      return "windows";
  }
  return "unknown";
}

std::string describe(const StepProgress& p) {
  if (p.number == 0) return "no step";
  const auto seconds = static_cast<std::int64_t>(p.seconds);
  std::string text = "step " + std::to_string(p.number) + "  " + std::to_string(seconds) + " s  " +
                     describe(p.stage);
  if (p.stage == StepStage::windows) return text;
  // The figures that tell most come first: a terminal may cut off the end.
  text += level_text(p);
  if (p.zone_rounds > 0 || p.impacts > 0)
    text += "  round " + std::to_string(p.zone_rounds) + ": " + std::to_string(p.zones) +
            " zones, " + std::to_string(p.impacts) + " impacts  " + percent(p.zone_work_left) +
            " zone work left";
  const int truncated_max = p.truncated_solves + p.truncated_solves_left;
  if (truncated_max > 0)
    text += "  " + std::to_string(p.truncated_solves) + " of " + std::to_string(truncated_max) +
            " truncated solves";
  return text + "  " + std::to_string(p.solves) + " solves";
}

}  // namespace weft
