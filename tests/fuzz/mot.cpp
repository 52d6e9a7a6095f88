#include <cmath>
#include <cstddef>

#include "host/io/arcsim/arcsim_motion.hpp"
#include "host/scene/validate.hpp"
#include "tests/fuzz/harness.hpp"
#include "tests/fuzz/targets.hpp"

namespace weft::fuzz {

void mot(std::string_view input) {
  const auto path = put("input.mot", input);
  Transform placement;
  placement.translate = {0.1, 0.2, 0.3};
  placement.rotation_angle = 1;
  placement.scale = 0.5;
  const auto motions = accepted([&] { return io::read_mot(path, 30, placement); });
  if (!motions) return;
  require(!motions->empty(), "no motion");
  for (const Motion& motion : *motions) {
    require(motion.size() >= 2, "a motion of one key");
    accepted([&] {
      validate_motion(motion, "input.mot", "motion");
      return true;
    });
    io::motion_json(io::composed(motion, placement));
  }
}

}  // namespace weft::fuzz
