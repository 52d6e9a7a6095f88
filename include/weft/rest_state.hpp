#pragma once

namespace weft {

/// A vertex of cloth moves if it is faster than this at the end of a frame, and was so on average
/// over the frame: jammed cloth may tremble without going anywhere. [m/s]
inline constexpr double moving_speed = 0.01;
/// Cloth is quiet at the end of a frame if no larger share of its vertices moves: the rule of
/// GarmentCode (Korosteleva & Sorkine-Hornung 2023), whose simulator stops at 1.5 %.
inline constexpr double moving_share_max = 0.015;
/// Cloth rests once it has been quiet for so long, frame after frame: a swing is slow at its
/// turning points too. [s]
inline constexpr double quiet_duration = 0.2;

/// Whether cloth rests. Only frames count that end after the last change that the scene has
/// planned: keys of motions, deformations, torques, handles, releases and the ramps of seams. What
/// a program moves or sets starts the count again.
struct RestState {
  double moving_share = 1;  ///< vertices that move over all vertices of cloth
  int quiet_frames = 0;     ///< in a row, up to the last one
  bool rested = false;
};

}  // namespace weft
