#include <cmath>
#include <limits>

#include "host/io/scene/scene_parts.hpp"

namespace weft::io {
namespace {

const std::vector<std::string> remeshing_keys{"size", "refine_angle", "refine_compression",
                                              "refine_velocity", "aspect_min"};

/// A limit, or null for infinity: it never refines.
double read_limit(Fields& fields, const std::string& key, double fallback) {
  if (!fields.has(key) && std::isfinite(fallback)) return fields.number(key, fallback);
  return fields.number_or_null(key).value_or(std::numeric_limits<double>::infinity());
}

Remeshing read_keys(Fields& fields, const Remeshing& fallback) {
  Remeshing r = fallback;
  if (fields.is_null("size")) {
    fields.record("size", nullptr);
    r.size_min = r.size_max = 0;
  } else if (fields.has("size") || r.size_min > 0) {
    const Vec2<double> size =
        fields.vector<2>("size", Vec2<double>{fallback.size_min, fallback.size_max});
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
  return r;
}

}  // namespace

Remeshing read_remeshing(Fields& owner, const Remeshing& fallback) {
  Fields fields = owner.object("remeshing", remeshing_keys);
  return read_keys(fields, fallback);
}

void read_adaptive(Fields& root, Scene& scene) {
  std::vector<std::string> keys = remeshing_keys;
  keys.insert(keys.end(), {"flip_threshold", "energy_share"});
  Fields fields = root.object("remeshing", keys);
  scene.adaptive.remeshing = read_keys(fields, scene.adaptive.remeshing);
  scene.adaptive.flip_threshold = fields.number("flip_threshold", scene.adaptive.flip_threshold);
  scene.adaptive.energy_share = read_limit(fields, "energy_share", scene.adaptive.energy_share);
}

}  // namespace weft::io
