#include "weft/report.hpp"

namespace weft {

const char* describe(Failure failure) {
  switch (failure) {
    case Failure::none:
      return "none";
    case Failure::not_finite:
      return "not finite";
    case Failure::not_converged:
      return "not converged";
    case Failure::intersection:
      return "intersection left";
    case Failure::pinched:
      return "pinched";
    case Failure::contact_motion:
      return "contacts move too far";
    case Failure::layers:
      return "out of penalty layers";
    case Failure::rollbacks:
      return "rolled back too often";
    case Failure::small_step:
      return "step too small";
    case Failure::stopped:
      return "stopped";
  }
  return "unknown";
}

const char* describe(FallbackLevel fallback_level) {
  switch (fallback_level) {
    case FallbackLevel::whole:
      return "whole";
    case FallbackLevel::halved:
      return "halved";
    case FallbackLevel::rigid:
      return "rigid";
    case FallbackLevel::truncated:
      return "truncated";
    case FallbackLevel::failed:
      return "failed";
  }
  return "unknown";
}

}  // namespace weft
