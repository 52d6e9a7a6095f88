#include "host/lab/check/report_json.hpp"

namespace weft::lab {
namespace {

using Json = nlohmann::ordered_json;

Json pairs_json(const FrameVerdict& verdict, PairKind kind, std::int64_t count) {
  Json pairs = Json::array();
  for (const auto& pair : verdict.pairs)
    if (pair.kind == kind) pairs.push_back(Json::array({pair.a, pair.b}));
  return {{"count", count}, {"pairs", std::move(pairs)}};
}

Json findings_json(const Findings& findings) {
  return {{"count", findings.count}, {"list", findings.list}};
}

Json percentiles_json(const Percentiles& p) {
  return {{"min", p.min}, {"p1", p.p1}, {"p50", p.p50}, {"p99", p.p99}, {"max", p.max}};
}

Json strain_json(const StrainVerdict& strain) {
  if (strain.triangle_count == 0) return nullptr;
  return {{"triangle_count", strain.triangle_count},
          {"largest", percentiles_json(strain.largest)},
          {"smallest", percentiles_json(strain.smallest)}};
}

}  // namespace

nlohmann::ordered_json to_json(const FrameVerdict& v) {
  return {{"clean", v.clean()},
          {"triangle_count", v.triangle_count},
          {"obstacle_triangle_count", v.obstacle_triangle_count},
          {"cloth_cloth", pairs_json(v, PairKind::cloth_cloth, v.cloth_cloth_count)},
          {"cloth_obstacle", pairs_json(v, PairKind::cloth_obstacle, v.cloth_obstacle_count)},
          {"inverted", findings_json(v.inverted)},
          {"degenerate", findings_json(v.degenerate)},
          {"nonfinite_vertices", findings_json(v.nonfinite)},
          {"nonfinite_obstacle_vertices", findings_json(v.nonfinite_obstacle)},
          {"strain", strain_json(v.strain)}};
}

}  // namespace weft::lab
