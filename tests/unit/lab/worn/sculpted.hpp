#pragma once

#include <string>
#include <vector>

#include "weft/scene.hpp"

namespace weft::lab::test {

/// A garment on a sculpted body as `weft check --worn` would read it. Nothing was simulated.
struct SculptedFit {
  std::string what;   ///< garment and what happened to it, for messages
  std::string fault;  ///< of a bad fit: words of the fault that was planted
  Mesh cloth, body;   ///< at the end
  std::vector<Vec3<double>> cloth_start, body_start;
  bool with_cloth_start = true, with_body_start = false;
  Vec3<double> up{0, 0, 1};
};

/// Fits of a set. Bodies, garments and sizes of what happened differ from set to set; of poses and
/// of what happened there are two lists, for even and for odd sets.
constexpr int fits_in_set = 15;

/// @param set not negative
/// @param n in [0, fits_in_set)
/// @return a garment that is worn as it was put on: it sags, turns, wrinkles and stretches by no
/// more than 0.6 of the limits that `weft check` promises
SculptedFit sculpted_good(int set, int n);

/// @return a garment that is not; what slid, turned or was stretched is beyond the limits by a
/// factor of 1.3 or more
SculptedFit sculpted_bad(int set, int n);

/// Motions of a body that its garment follows without a fault.
enum class Motion { reaches_forward, turns_trunk, steps_wide, bends_arms };

/// @return a garment with sleeves or legs that goes along
SculptedFit sculpted_motion(Motion motion);

/// @param share of the body's height
/// @return a long dress whose hem has gone up by so much, in folds
SculptedFit sculpted_hitched(double share);

/// @return trousers of which the legs hang below the soles
SculptedFit sculpted_long_trousers();

}  // namespace weft::lab::test
