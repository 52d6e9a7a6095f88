#pragma once

namespace weft {

/// A vertex of cloth moves if it is faster than this at the end of a frame, and was so on average
/// over the frame. [m/s]
inline constexpr double moving_speed = 0.01;
/// Cloth rests once it has been quiet for so long, frame after frame. [s]
inline constexpr double quiet_duration = 0.2;
/// Cloth is quiet as long as no larger share of its vertices has gone farther from where it was
/// before the first quiet frame than moving_speed leads in quiet_duration: jammed cloth trembles
/// without going anywhere. The rule of GarmentCode (Korosteleva & Sorkine-Hornung 2023), whose
/// simulator stops at 1.5 %.
inline constexpr double displaced_share_max = 0.015;
/// And as long as no larger share moves at once: a swing hardly gets anywhere about its turning
/// points.
inline constexpr double moving_share_max = 0.05;

/// Whether cloth rests. Only frames count that end after the last change that the scene has
/// planned: keys of motions, deformations, torques, handles, releases and the ramps of seams. What
/// a program moves or sets starts the count again.
struct RestState {
  double moving_share = 1;     ///< vertices that move over all vertices of cloth
  double displaced_share = 1;  ///< those that have gone too far over all
  int quiet_frames = 0;        ///< in a row, up to the last one
  bool rested = false;
};

}  // namespace weft
