#pragma once

#include <cstdint>
#include <string>

#include "weft/report.hpp"

namespace weft {

/// What a time step is doing.
enum class StepStage {
  none,        ///< no step is under way
  prediction,  ///< obstacles, pins and free motion
  contacts,    ///< broad phase, and contacts within the thickness
  solve,       ///< assembly and linear solves
  detection,   ///< continuous detection
  zones,       ///< impact zones
  truncation,  ///< motions are cut off before they meet something
  remeshing,   ///< after the last step of a frame: seams are welded, meshes change
  windows,     ///< all of a step of the method asynchronous
};

/// For example "impact zones"; "none" for StepStage::none.
const char* describe(StepStage stage);

/// How far the present time step is, see Simulation::progress(). With the method asynchronous only
/// `number`, `seconds` and `stage` have a meaning.
struct StepProgress {
  std::int64_t number = 0;  ///< of the step, from 1; 0: no step is under way
  double seconds = 0;       ///< [s] wall time since the step began
  StepStage stage = StepStage::none;
  /// The deepest level that the step has fallen back to so far.
  FallbackLevel fallback_level = FallbackLevel::whole;
  double substep = 1;        ///< length of the present substep divided by that of the step
  double done = 0;           ///< share of the step's length that finished substeps cover, 0 to 1
  int solves = 0;            ///< linear solves so far
  int zone_rounds = 0;       ///< rounds of impact zones so far
  int zones = 0;             ///< in the latest round; 0 in the stage `truncation`
  std::int64_t impacts = 0;  ///< found before the latest round
  /// Share of the bounded work of impact zones that is left, 0 to 1. The step is truncated if it is
  /// used up. Truncated parts of a step have a bound of their own.
  double zone_work_left = 1;
  int truncated_solves = 0;       ///< solves of truncated parts so far
  int truncated_solves_left = 0;  ///< the step fails if they are used up; 0 before truncation
};

/// One line, for example "step 12  63 s  impact zones  halved 1/4 at 50%  round 7: 5 zones, 1240
/// impacts  38% zone work left  31 solves".
std::string describe(const StepProgress& progress);

}  // namespace weft
