#include <cmath>
#include <limits>

#include "host/io/scene/scene_parts.hpp"

namespace weft::io {
namespace {

/// A limit, or null for infinity: it never refines.
double read_limit(Fields& fields, const std::string& key, double fallback) {
  if (!fields.has(key) && std::isfinite(fallback)) return fields.number(key, fallback);
  return fields.number_or_null(key).value_or(std::numeric_limits<double>::infinity());
}

void read_criteria(Fields& fields, Remeshing& r) {
  if (fields.is_null("size")) {
    fields.record("size", nullptr);
    r.size_min = r.size_max = 0;
  } else if (fields.has("size") || r.size_min > 0) {
    const Vec2<double> size = fields.vector<2>("size", Vec2<double>{r.size_min, r.size_max});
    if (!(size[0] > 0)) fields.refuse("size", "[least, greatest] > 0");
    if (!(size[1] >= size[0])) fields.refuse("size", "[least, greatest], least <= greatest");
    r.size_min = size[0];
    r.size_max = size[1];
  } else {
    fields.record("size", nullptr);
  }
  r.refine_angle = read_limit(fields, "refine_angle", r.refine_angle);
  r.refine_compression = read_limit(fields, "refine_compression", r.refine_compression);
  r.refine_velocity = read_limit(fields, "refine_velocity", r.refine_velocity);
  r.aspect_min = fields.number("aspect_min", r.aspect_min);
}

}  // namespace

void read_adaptive(Fields& root, Scene& scene) {
  Fields fields =
      root.object("remeshing", {"size", "refine_angle", "refine_compression", "refine_velocity",
                                "aspect_min", "flip_threshold", "energy_share"});
  read_criteria(fields, scene.adaptive.remeshing);
  scene.adaptive.flip_threshold = fields.number("flip_threshold", scene.adaptive.flip_threshold);
  scene.adaptive.energy_share = read_limit(fields, "energy_share", scene.adaptive.energy_share);
}

}  // namespace weft::io
