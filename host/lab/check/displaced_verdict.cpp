#include "host/lab/check/displaced_verdict.hpp"

namespace weft::lab {

bool DisplacedVerdict::clean_against_displaced() const {
  return displaced && displaced->clean() && prescribed.cloth_cloth_count == 0 &&
         prescribed.nonfinite_obstacle.count == 0;
}

std::int64_t DisplacedVerdict::intersections() const {
  return clean_against_displaced() ? 0
                                   : prescribed.cloth_cloth_count + prescribed.cloth_obstacle_count;
}

DisplacedVerdict validate(const Mesh& cloth, const Mesh* obstacle, const Mesh* displaced,
                          const ValidatorOptions& options) {
  DisplacedVerdict verdict{validate(cloth, obstacle, options)};
  if (displaced == nullptr || verdict.prescribed.cloth_obstacle_count == 0) return verdict;
  ValidatorOptions bodies = options;
  bodies.self = false;  // the cloth is the same
  verdict.displaced = validate(cloth, displaced, bodies);
  return verdict;
}

}  // namespace weft::lab
