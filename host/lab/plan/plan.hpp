#pragma once

#include <string>
#include <vector>

#include "weft/scene.hpp"

/// What a scene needs, as far as that can be told without simulating it.
namespace weft::lab {

enum class Verdict {
  needed,    ///< results depend on it, or nothing proves that they do not
  left_out,  ///< the scene has nothing for it to do: results are the same bits without it
  in_need,   ///< left out: what that changes was measured, and is within the stated need
  offered,   ///< may be left out, or made cheaper, at an error that only runs can tell
  missing,   ///< this build has no way of leaving it out
};

/// "needed", "left out", "within need", "try without" or "not offered".
const char* describe(Verdict verdict);

struct StagePlan {
  std::string stage;
  Verdict verdict = Verdict::needed;
  std::string why;      ///< one line
  std::string setting;  ///< what is worth giving to --set for that; empty: nothing
  /// What turns it off for --set; if it is left out, that changes no bit. Empty: there is nothing.
  std::string off{};
};

/// Stage by stage, in the order of a step. What is `left_out` is so whatever happens in the run.
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
