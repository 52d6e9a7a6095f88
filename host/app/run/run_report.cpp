#include "host/app/run/run_report.hpp"

#include <fmt/format.h>
#include <sys/resource.h>

#include "host/app/run/report_fields.hpp"
#include "host/app/run/seam_verdict.hpp"
#include "weft/version.hpp"

namespace weft::app {
namespace {

/// Counts changes of report.json's keys; that of version 0.1, which said none, was 1.
constexpr int report_schema_version = 2;

constexpr FallbackLevel fallback_levels[] = {FallbackLevel::whole, FallbackLevel::halved,
                                             FallbackLevel::rigid, FallbackLevel::truncated,
                                             FallbackLevel::failed};

/// What slept of a run: sums, and the share of the vertices on average over the steps.
Json sleep_json(const RunTotals& totals, std::size_t vertices) {
  Json json = json_of(totals.sleep);
  json["asleep"] = static_cast<double>(totals.sleep.asleep) /
                   (static_cast<double>(vertices) * static_cast<double>(totals.steps));
  return json;
}

Json place_json(const Vec3<double>& place) {
  return {place[0], place[1], place[2]};
}

/// How the seams of garments were closed.
Json garments_json(const Scene& scene) {
  Json list = Json::array();
  for (const GarmentStart& start : scene.garment_starts)
    list.push_back({{"garment", scene.cloths[static_cast<std::size_t>(start.cloth)].name},
                    {"start", start.start == SewnStart::springs ? "springs" : "welded"},
                    {"reason", start.reason.empty() ? Json(nullptr) : Json(start.reason)}});
  return list;
}

/// What handles, and the attachments of garments, do to cloth at the end.
Json handles_json(const std::vector<HandleState>& handles) {
  Json list = Json::array();
  for (const HandleState& handle : handles)
    list.push_back({{"cloth", handle.cloth},
                    {"force_n", place_json(handle.force)},
                    {"weight_share", handle.weight_share}});
  return list;
}

/// How many steps went down to which fallback level.
Json fallback_levels_json(const RunTotals& totals) {
  Json json;
  for (const FallbackLevel fallback_level : fallback_levels)
    json[describe(fallback_level)] =
        totals.steps_at_fallback_level[static_cast<std::size_t>(fallback_level)];
  return json;
}

/// In how many steps cloth was proved to stay apart from itself, what that took, and what contacts
/// and certification took in a step with and without.
Json certificate_json(const RunTotals& totals) {
  const auto ms = [](const RunTotals::Certified& c) {
    return c.steps > 0 ? Json(1e3 * c.seconds / static_cast<double>(c.steps)) : Json(nullptr);
  };
  const auto &with = totals.with_certificate, &without = totals.without_certificate;
  return {{"steps", with.steps},
          {"ms", 1e3 * (with.certificate + without.certificate)},
          {"ms_a_step_with", ms(with)},
          {"ms_a_step_without", ms(without)}};
}

/// null with a method that solves no linear systems.
Json transport_json(const Simulation& simulation) {
  if (simulation.scene().method == "asynchronous") return nullptr;
  return simulation.transport() == Transport::pipelined ? "pipelined" : "peer";
}

/// A rank an object: what its memory is for, and most bytes of each.
Json uses_json(const Simulation& simulation) {
  Json ranks = Json::array();
  for (const std::vector<MemoryUse>& uses : simulation.device_memory()) {
    Json rank = Json::object();
    for (const MemoryUse& use : uses) rank[use.name] = use.peak_bytes;
    ranks.push_back(rank);
  }
  return ranks;
}

std::int64_t peak_host_bytes() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return std::int64_t{usage.ru_maxrss} * 1024;  // Linux counts in KiB
}

}  // namespace

std::string hash_text(std::uint64_t hash) {
  return fmt::format("{:016x}", hash);
}

Json make_report(const Simulation& simulation, const RunTotals& totals, const RunFacts& facts) {
  const Scene& scene = simulation.scene();
  const BuildInfo& build = build_info();
  const Energy energy = simulation.energy();
  const auto drift = totals.drift(energy);
  std::size_t vertices = 0, triangles = 0;
  for (const Cloth& cloth : scene.cloths) {
    vertices += cloth.mesh.positions.size();
    triangles += cloth.mesh.triangles.size();
  }
  const double mean = totals.solves > 0 ? static_cast<double>(totals.iterations) /
                                              static_cast<double>(totals.solves)
                                        : 0.0;
  Json report{{"schema_version", report_schema_version},
              {"scene", scene.name},
              {"method", scene.method},
              {"device", facts.device.text},
              {"precision", scene.precision == Precision::single_precision ? "float" : "double"},
              {"build",
               {{"commit", build.commit},
                {"dirty", build.dirty},
                {"compiler", build.compiler},
                {"cuda", build.cuda}}},
              {"frames", simulation.frame_number()},
              {"steps", simulation.step_number()},
              {"simulated_s", simulation.time()},
              {"wall_s", totals.wall},
              {"stages_ms", json_of(totals.stages)},
              {"vertex_count", vertices},
              {"triangle_count", triangles},
              {"solver",
               {{"iterations_mean", mean},
                {"iterations_max", totals.iterations_max},
                {"residual_max", totals.residual_max},
                {"transport", transport_json(simulation)}}},
              {"contacts",
               {{"proximities_max", totals.proximities_max},
                {"impacts_total", totals.impacts},
                {"zones_max", totals.zones_max},
                {"zone_rounds_max", totals.zone_rounds_max},
                {"zone_largest", totals.zone_largest},
                {"zone_passes_total", totals.zone_passes},
                {"zones_unsolved_total", totals.zones_unsolved},
                {"plane_zones_total", totals.plane_zones},
                {"rigid_zones_total", totals.rigid_zones},
                {"truncations_total", totals.truncations},
                {"compliance_distance_max", totals.compliance_distance_max},
                {"retries", totals.retries},
                {"steps_at_fallback_level", fallback_levels_json(totals)}}},
              {"self_certificate", certificate_json(totals)},
              {"intersections", facts.verdict.intersections()},
              {"clean_against_displaced", facts.verdict.clean_against_displaced()},
              {"intersections_checked", facts.at_frame ? "last frame" : "last state"},
              {"energy",
               {{"kinetic", energy.kinetic},
                {"potential", energy.elastic + energy.gravitational},
                {"drift", drift ? Json(*drift) : Json(nullptr)},
                {"gain", facts.energy_gain ? Json(*facts.energy_gain) : Json(nullptr)}}},
              {"peak_bytes",
               {{"host", peak_host_bytes()},
                {"device", simulation.peak_device_bytes()},
                {"device_by_use", uses_json(simulation)}}},
              {"state_hash", hash_text(simulation.state_hash())}};
  if (scene.method == "asynchronous") report["asynchronous"] = json_of(totals.asynchronous);
  if (!scene.garment_starts.empty()) report["garments"] = garments_json(scene);
  if (!scene.handles.empty()) report["handles"] = handles_json(simulation.handles());
  if (!scene.seams.empty()) report["seams"] = seams_json(simulation.seams());
  if (totals.balance.rows.even > 0) report["balance"] = json_of(totals.balance);
  if (totals.automatic.steps > 0)
    report["time_steps"] = {{"shortest", totals.automatic.shortest},
                            {"longest", totals.automatic.longest},
                            {"error_max", totals.automatic.error_max},
                            {"rejected", totals.automatic.rejected}};
  if (scene.time.until == RunUntil::rest) {
    const RestState rest = simulation.rest();
    report["rested"] = rest.rested;
    report["rested_at_s"] = rest.rested ? Json(simulation.time()) : Json(nullptr);
    report["moving_share"] = rest.moving_share;
    report["displaced_share"] = rest.displaced_share;
  }
  if (totals.limit_excess) report["limit_excess_max"] = *totals.limit_excess;
  if (totals.sleep.pieces > 0) report["sleep"] = sleep_json(totals, vertices);
  if (totals.remeshes > 0) {
    report["remeshing"] = json_of(totals.remesh);
    report["remeshing"]["remeshes"] = totals.remeshes;
    report["remeshing"]["energy_jump_share"] =
        totals.kinetic_max > 0 ? Json(totals.remesh.energy_jump / totals.kinetic_max)
                               : Json(nullptr);
  }
  if (facts.device.choice) report["device_choice"] = choice_json(*facts.device.choice);
  if (simulation.origin() != Vec3<double>{0, 0, 0})
    report["origin"] = place_json(simulation.origin());
  if (facts.failure) report["failure"] = *facts.failure;
  if (facts.failure_place) report["failure_place"] = place_json(*facts.failure_place);
  return report;
}

}  // namespace weft::app
