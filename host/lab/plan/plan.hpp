#pragma once

#include <string>
#include <vector>

#include "weft/scene.hpp"

/// The stages that a scene needs, as far as this is known without simulating it.
namespace weft::lab {

enum class Verdict {
  needed,    ///< results depend on it, or nothing proves that they do not
  left_out,  ///< the scene has nothing for it to do: results are the same bits without it
  in_need,   ///< left out: the measured change is within the accuracy target
  offered,   ///< may be left out or made cheaper; only runs can tell the error
  missing,   ///< this build cannot leave it out
};

/// "needed", "left out", "within target", "try without" or "not offered".
const char* describe(Verdict verdict);

struct StagePlan {
  std::string stage;
  Verdict verdict = Verdict::needed;
  std::string why;      ///< one line
  std::string setting;  ///< suggested "path=value"; empty: none
  /// Argument of --set that turns the stage off; empty: none. If the stage is
  /// left out, this changes no bits.
  std::string off{};
};

/// Stage by stage, in the order of a step. A stage that is `left_out` stays so for the whole run.
/// @param scene valid
std::vector<StagePlan> plan_stages(const Scene& scene);

/// Length over which a sheet bends under its own weight: (D / (density g))^(1/3). Features of
/// bending are about as wide. [m] The largest of all materials; 0 without gravity or bending.
double bending_length(const Scene& scene);

/// Mean edge of the cloths' triangles at rest. [m]
double mean_edge(const Scene& scene);

/// The farthest coordinate of any cloth, obstacle or motion from the origin. [m]
double largest_coordinate(const Scene& scene);

}  // namespace weft::lab
