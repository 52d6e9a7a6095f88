#include "host/io/arcsim/arcsim_remeshing.hpp"

#include <algorithm>

namespace weft::io {

nlohmann::json read_arcsim_remeshing(Fields& cloth) {
  Fields block = cloth.object(
      "remeshing", {"refine_angle", "refine_compression", "refine_velocity", "size", "aspect_min"});
  if (!block.has("size")) return nullptr;
  nlohmann::json entry = nlohmann::json::object();
  for (const char* key : {"refine_angle", "refine_compression", "refine_velocity"})
    entry[key] = block.has(key) ? nlohmann::json(block.positive(key)) : nlohmann::json(nullptr);
  const Vec2<double> size = block.vector<2>("size");
  if (!(size[0] > 0) || !(size[1] >= size[0]))
    block.refuse("size", "[least, greatest], 0 < least <= greatest");
  entry["size"] = {size[0], size[1]};
  entry["aspect_min"] = std::max(0.0, block.number("aspect_min", 0.0));
  return entry;
}

}  // namespace weft::io
