#include "host/io/animation/bvh_file.hpp"

#include <cmath>
#include <cstddef>

#include "host/io/animation/capture_body.hpp"
#include "tests/fuzz/harness.hpp"
#include "tests/fuzz/targets.hpp"

namespace weft::fuzz {
namespace {

void require_whole(const io::Capture& capture) {
  require(!capture.joints.empty() && capture.frame_count > 0, "a capture without content");
  require(capture.frame_time > 0, "frames without length");
  require(capture.values.size() == capture.frame_count * capture.channel_count,
          "another number of values");
  for (const double value : capture.values)
    require(std::isfinite(value), "a value that is not finite");
  for (std::size_t j = 0; j < capture.joints.size(); ++j) {
    const io::CaptureJoint& joint = capture.joints[j];
    require(joint.parent >= -1 && joint.parent < static_cast<Index>(j),
            "a child before its parent");
    require(joint.channels.empty() ||
                joint.first_channel + joint.channels.size() <= capture.channel_count,
            "channels out of range");
  }
}

}  // namespace

void bvh(std::string_view input) {
  const auto capture = accepted([&] { return io::parse_bvh(input, "input.bvh"); });
  if (!capture) return;
  require_whole(*capture);
  io::CaptureBody body;
  body.scale = 1.7 / io::capture_height(*capture, body.y_up);
  // Scenes allow no other scale. Many bones take long without showing anything new.
  if (!(body.scale >= 1e-9 && body.scale <= 1e9) || capture->joints.size() > 16) return;
  body.edge = 0.3;
  body.last_frame = capture->frame_count - 1;
  accepted([&] {
    const SkinnedSurface surface = io::make_capture_body(*capture, body, "input.bvh");
    std::vector<Vec3<double>> positions(surface.skin.rest.size());
    SkinnedDeformation(surface.skin, Playback()).positions(0.01, positions);
    for (const Vec3<double>& x : positions)
      for (int k = 0; k < 3; ++k) require(std::isfinite(x[k]), "a body that is not finite");
    return true;
  });
}

}  // namespace weft::fuzz
