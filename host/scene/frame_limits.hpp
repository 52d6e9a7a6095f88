#pragma once

namespace weft {

/// Frames that a .glb holds at most: weights of morph targets take their square, and programs that
/// read them a shape for each.
constexpr int max_glb_frames = 2000;

/// Bytes of a .glb at most: 32 bits say how long it is.
constexpr double max_glb_bytes = 4294967295.0;

/// Bytes in a .glb of a vertex that moves, per frame: a point and a normal.
constexpr double glb_bytes_per_vertex = 24;

}  // namespace weft
