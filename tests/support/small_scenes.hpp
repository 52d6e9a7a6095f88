#pragma once

#include "weft/scene.hpp"

namespace weft::test {

/// A square sheet of cells x cells quads and side 0.4 m, lying at height z.
Cloth sheet(int cells, double z);

/// One light material with damping.
Material cotton();

/// A sheet that falls over a coarse sphere, in contact within a few steps.
Scene sheet_on_sphere(Precision precision, int cells = 14);

/// Two sheets that fall on each other and on a box.
Scene two_sheets(Precision precision);

/// Two sheets that float. One is thrown at the other, which is turned against it.
/// @param speed [m/s]
Scene thrown_sheet(double speed);

/// A sheet that hangs by two corners, one of which is carried to and fro.
Scene hanging_sheet(Precision precision, Integrator integrator);

/// A sheet that is clamped along two rows of vertices until 0.06 s, and then along none.
Scene released_sheet(Precision precision);

/// A sheet that is rolled up at rest and starts flat, held at one end until 0.06 s.
Scene curled_sheet(Precision precision, Bending bending);

/// A napkin, one pinned edge of which is carried onto the opposite one within 0.1 s.
Scene folded_napkin(Precision precision);

}  // namespace weft::test
