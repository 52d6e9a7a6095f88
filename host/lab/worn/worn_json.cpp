#include "host/lab/worn/worn_json.hpp"

namespace weft::lab {
namespace {

using Json = nlohmann::ordered_json;

template <class T>
Json known(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

}  // namespace

nlohmann::ordered_json to_json(const GarmentVerdict& verdict) {
  Json openings = Json::array(), panels = Json::array();
  for (const OpeningVerdict& o : verdict.openings)
    openings.push_back({{"panels", o.panels},
                        {"around", o.around},
                        {"around_at_start", known(o.around_at_start)},
                        {"length_m", o.length},
                        {"slide_m", known(o.slide)},
                        {"twist_degrees", known(o.twist)}});
  for (const PanelVerdict& p : verdict.panels)
    panels.push_back({{"name", p.name},
                      {"part", p.part},
                      {"drift_m", known(p.drift)},
                      {"twist_degrees", known(p.twist)},
                      {"outward", p.outward},
                      {"outward_at_start", known(p.outward_at_start)},
                      {"stretch_max", known(p.stretch)},
                      {"stretched_share", p.stretched}});
  return {{"garment", verdict.name},         {"worn", verdict.worn()},
          {"faults", verdict.faults},        {"shoulders_covered", known(verdict.shoulders)},
          {"openings", std::move(openings)}, {"panels", std::move(panels)}};
}

}  // namespace weft::lab
