#include "host/app/run/run_report.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <sstream>
#include <string_view>
#include <system_error>

#include "host/app/run/balance_report.hpp"
#include "host/app/run/seam_verdict.hpp"
#include "host/base/atomic_file.hpp"
#include "host/base/file_bytes.hpp"
#include "weft/error.hpp"
#include "weft/version.hpp"

namespace weft::app {
namespace {

/// Counts changes of report.json's keys; that of version 0.1, which said none, was 1.
constexpr int report_schema_version = 2;

using Json = nlohmann::ordered_json;

constexpr FallbackLevel fallback_levels[] = {FallbackLevel::whole, FallbackLevel::halved,
                                             FallbackLevel::rigid, FallbackLevel::truncated,
                                             FallbackLevel::failed};

Json stages_json(const StageTimes& s) {
  return {{"contacts", s.contacts * 1e3},
          {"assemble", s.assemble * 1e3},
          {"solve", s.solve * 1e3},
          {"resolve_collisions", s.resolve_collisions * 1e3},
          {"other", s.other * 1e3}};
}

Json collision_times_json(const CollisionTimes& c) {
  return {{"detection", c.detection * 1e3},
          {"searches", c.searches * 1e3},
          {"solves", c.solves * 1e3},
          {"zones", c.zones * 1e3}};
}

/// Counts of the asynchronous method; its times are in ms.
Json asynchronous_json(const AsynchronousCounts& c) {
  return {{"windows", c.windows},
          {"clean_windows", c.clean_windows},
          {"rollbacks", c.rollbacks},
          {"window_s", c.window_length},
          {"ahead_started", c.ahead_started},
          {"ahead_accepted", c.ahead_accepted},
          {"ahead_cancelled", c.ahead_cancelled},
          {"ahead_held", c.ahead_held},
          {"ticks", c.ticks},
          {"elements", c.elements},
          {"layer_pairs", c.layer_pairs},
          {"acting_pairs", c.acting_pairs},
          {"resimulated", c.resimulated},
          {"layers_added", c.layers_added},
          {"candidates", c.candidates},
          {"slabs", c.slabs},
          {"failsafe", c.failsafe},
          {"ccd_tests", c.ccd_tests},
          {"pairs_max", c.pairs_max},
          {"layers_max", c.layers_max},
          {"useful_ms", c.useful * 1e3},
          {"resimulation_ms", c.resimulation * 1e3},
          {"detection_ms", c.detection * 1e3},
          {"unneeded_ms", c.unneeded * 1e3},
          {"bookkeeping_ms", c.bookkeeping * 1e3},
          {"beside_detection_ms", c.beside_detection * 1e3}};
}

Json remesh_json(const RemeshReport& r) {
  return {{"splits", r.splits},           {"flips", r.flips},
          {"collapses", r.collapses},     {"refused", r.refused},
          {"redone", r.redone},           {"vertices", r.vertices},
          {"triangles", r.triangles},     {"energy_jump", r.energy_jump},
          {"ms", r.seconds * 1e3},        {"rebuild_ms", r.rebuild_seconds * 1e3},
          {"cpu_ms", r.cpu_seconds * 1e3}};
}

Json sleep_json(const SleepReport& r) {
  return {{"pieces", r.pieces}, {"asleep", r.asleep}, {"fell_asleep", r.fell_asleep},
          {"woken", r.woken},   {"redone", r.redone}, {"departure", r.departure}};
}

/// What slept of a run: sums, and the share of the vertices on average over the steps.
Json sleep_json(const RunTotals& totals, std::size_t vertices) {
  Json json = sleep_json(totals.sleep);
  json["asleep"] = static_cast<double>(totals.sleep.asleep) /
                   (static_cast<double>(vertices) * static_cast<double>(totals.steps));
  return json;
}

Json place_json(const Vec3<double>& place) {
  return {place[0], place[1], place[2]};
}

Json line_json(const StepLine& line) {
  const StepReport& r = line.report;
  Json json{{"number", r.number},
            {"time", r.time},
            {"step", r.step},
            {"wall_s", line.wall},
            {"solves", r.solves},
            {"iterations", r.iterations},
            {"iterations_max", r.iterations_max},
            {"residual_max", r.residual_max},
            {"newton_iterations", r.newton_iterations},
            {"newton_residual", r.newton_residual},
            {"line_steps", r.line_steps},
            {"active_set_iterations", r.active_set_iterations},
            {"searches", r.searches},
            {"self_certified", r.self_certified},
            {"certificate_ms", r.certificate_seconds * 1e3},
            {"face_pairs", r.face_pairs},
            {"edge_pairs", r.edge_pairs},
            {"proximities", r.proximities},
            {"impacts", r.impacts},
            {"ccd_tests", r.ccd_tests},
            {"zone_rounds", r.zone_rounds},
            {"zones", r.zones},
            {"zone_largest", r.zone_largest},
            {"zone_passes", r.zone_passes},
            {"zone_visits", r.zone_visits},
            {"zones_unsolved", r.zones_unsolved},
            {"plane_zones", r.plane_zones},
            {"rigid_zones", r.rigid_zones},
            {"truncations", r.truncations},
            {"fallback_level", describe(r.fallback_level)},
            {"compliant", r.compliant},
            {"compliance_distance", r.compliance_distance},
            {"retries", r.retries},
            {"rebuilds", r.rebuilds},
            {"open_seam_pairs", r.open_seam_pairs},
            {"allocations", r.allocations},
            {"synchronisations", r.synchronisations},
            {"failure", describe(r.failure)},
            {"failure_detail", r.failure_detail},
            {"stages_ms", stages_json(r.stages)}};
  if (r.step_error) {
    json["step_error"] = *r.step_error;
    json["rejected"] = r.rejected;
  }
  if (r.work) json["work"] = *r.work;
  if (r.limit_excess) json["limit_excess"] = *r.limit_excess;
  if (r.moving_share) json["moving_share"] = *r.moving_share;
  if (r.failure_place) json["failure_place"] = place_json(*r.failure_place);
  if (r.resolve_collisions.total() > 0)
    json["resolve_collisions_ms"] = collision_times_json(r.resolve_collisions);
  if (r.asynchronous.windows > 0) json["asynchronous"] = asynchronous_json(r.asynchronous);
  if (r.remesh.triangles > 0) json["remesh"] = remesh_json(r.remesh);
  if (r.remesh.factor_mean > 0) {
    json["remesh"]["in_view"] = r.remesh.in_view;
    json["remesh"]["factor_mean"] = r.remesh.factor_mean;
  }
  if (r.sleep.pieces > 0) json["sleep"] = sleep_json(r.sleep);
  if (r.balance.rows.even > 0) json["balance"] = balance_json(r.balance);
  if (line.energy)
    json["energy"] = {{"kinetic", line.energy->kinetic},
                      {"elastic", line.energy->elastic},
                      {"gravitational", line.energy->gravitational}};
  return json;
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

/// A number as it was written; JSON has none for NaN and infinity and holds null instead.
double number_or_nan(const Json& json) {
  return json.is_null() ? std::nan("") : json.get<double>();
}

/// @throws Json::exception if there is no such fallback level
FallbackLevel fallback_level_of(const std::string& name) {
  for (const FallbackLevel fallback_level : fallback_levels)
    if (name == describe(fallback_level)) return fallback_level;
  throw Json::other_error::create(501, "no fallback_level: " + name, nullptr);
}

/// What asynchronous_json() made.
AsynchronousCounts parse_asynchronous(const Json& json) {
  AsynchronousCounts c;
  const auto count = [&](const char* key) { return json.at(key).get<std::int64_t>(); };
  const auto ms = [&](const char* key) { return json.at(key).get<double>() / 1e3; };
  c.windows = count("windows");
  c.clean_windows = count("clean_windows");
  c.rollbacks = count("rollbacks");
  c.window_length = json.at("window_s").get<double>();
  // Not in logs of earlier versions.
  c.ahead_started = json.value("ahead_started", std::int64_t{0});
  c.ahead_accepted = json.value("ahead_accepted", std::int64_t{0});
  c.ahead_cancelled = json.value("ahead_cancelled", std::int64_t{0});
  c.ahead_held = json.value("ahead_held", std::int64_t{0});
  c.ticks = count("ticks");
  c.elements = count("elements");
  c.layer_pairs = count("layer_pairs");
  c.acting_pairs = count("acting_pairs");
  c.resimulated = count("resimulated");
  c.layers_added = count("layers_added");
  c.candidates = count("candidates");
  c.slabs = count("slabs");
  c.failsafe = count("failsafe");
  c.ccd_tests = count("ccd_tests");
  c.pairs_max = count("pairs_max");
  c.layers_max = json.at("layers_max").get<int>();
  c.useful = ms("useful_ms");
  c.resimulation = ms("resimulation_ms");
  c.detection = ms("detection_ms");
  c.unneeded = ms("unneeded_ms");
  c.bookkeeping = ms("bookkeeping_ms");
  c.beside_detection = json.value("beside_detection_ms", 0.0) / 1e3;
  return c;
}

SleepReport parse_sleep(const Json& json) {
  const auto count = [&](const char* name) { return json.at(name).get<std::int64_t>(); };
  return {count("pieces"), count("asleep"), count("fell_asleep"),
          count("woken"),  count("redone"), number_or_nan(json.at("departure"))};
}

/// How many steps went down to which fallback level.
Json fallback_levels_json(const RunTotals& totals) {
  Json json;
  for (const FallbackLevel fallback_level : fallback_levels)
    json[describe(fallback_level)] =
        totals.steps_at_fallback_level[static_cast<std::size_t>(fallback_level)];
  return json;
}

/// What RunTotals needs of a line.
/// @throws Json::exception if the line is none of ours
StepLine parse_line(std::string_view text) {
  const Json json = Json::parse(text);
  StepLine line;
  line.report.number = json.at("number").get<std::int64_t>();
  line.report.time = json.at("time").get<double>();
  line.report.step = json.at("step").get<double>();
  if (json.contains("step_error")) {
    line.report.step_error = number_or_nan(json.at("step_error"));
    line.report.rejected = json.at("rejected").get<int>();
  }
  line.report.open_seam_pairs =
      json.value("open_seam_pairs", std::int64_t{0});  // not in older logs
  if (json.contains("work")) line.report.work = number_or_nan(json.at("work"));
  if (json.contains("limit_excess"))
    line.report.limit_excess = number_or_nan(json.at("limit_excess"));
  line.wall = json.at("wall_s").get<double>();
  line.report.solves = json.at("solves").get<int>();
  line.report.iterations = json.at("iterations").get<int>();
  line.report.iterations_max = json.at("iterations_max").get<int>();
  line.report.residual_max = number_or_nan(json.at("residual_max"));
  line.report.proximities = json.at("proximities").get<std::int64_t>();
  line.report.self_certified = json.value("self_certified", false);
  line.report.certificate_seconds = json.value("certificate_ms", 0.0) / 1e3;
  line.report.impacts = json.at("impacts").get<std::int64_t>();
  line.report.zones = json.at("zones").get<int>();
  line.report.zone_rounds = json.at("zone_rounds").get<int>();
  line.report.zone_largest = json.at("zone_largest").get<int>();
  line.report.zone_passes = json.at("zone_passes").get<std::int64_t>();
  line.report.zone_visits = json.value("zone_visits", std::int64_t{0});  // not in older logs
  line.report.zones_unsolved = json.at("zones_unsolved").get<int>();
  line.report.plane_zones = json.at("plane_zones").get<int>();
  line.report.rigid_zones = json.at("rigid_zones").get<int>();
  line.report.truncations = json.at("truncations").get<int>();
  line.report.fallback_level = fallback_level_of(json.at("fallback_level").get<std::string>());
  line.report.compliance_distance = number_or_nan(json.at("compliance_distance"));
  line.report.retries = json.at("retries").get<int>();
  const Json& stages = json.at("stages_ms");
  line.report.stages = {
      stages.at("contacts").get<double>() / 1e3, stages.at("assemble").get<double>() / 1e3,
      stages.at("solve").get<double>() / 1e3, stages.at("resolve_collisions").get<double>() / 1e3,
      stages.at("other").get<double>() / 1e3};
  if (json.contains("asynchronous"))
    line.report.asynchronous = parse_asynchronous(json.at("asynchronous"));
  if (json.contains("remesh")) {
    const Json& r = json.at("remesh");
    const auto count = [&r](const char* key) { return r.value(key, std::int64_t{0}); };
    line.report.remesh = {r.at("splits").get<std::int64_t>(),
                          r.at("flips").get<std::int64_t>(),
                          r.at("collapses").get<std::int64_t>(),
                          r.at("refused").get<std::int64_t>(),
                          count("redone"),
                          r.at("vertices").get<std::int64_t>(),
                          r.at("triangles").get<std::int64_t>(),
                          number_or_nan(r.at("energy_jump")),
                          r.at("ms").get<double>() / 1e3,
                          r.value("rebuild_ms", 0.0) / 1e3,
                          r.value("cpu_ms", 0.0) / 1e3};
  }
  if (json.contains("balance")) line.report.balance = parse_balance(json.at("balance"));
  if (json.contains("sleep")) line.report.sleep = parse_sleep(json.at("sleep"));
  if (json.contains("energy")) {
    const Json& energy = json.at("energy");
    line.energy = Energy{number_or_nan(energy.at("kinetic")), number_or_nan(energy.at("elastic")),
                         number_or_nan(energy.at("gravitational"))};
  }
  return line;
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

[[noreturn]] void fail(const std::string& file, const char* what) {
  throw SceneError(file + ": cannot " + what + ": " + std::generic_category().message(errno));
}

}  // namespace

StepLog::StepLog(const std::filesystem::path& file, const std::string& kept)
    : file_(file.string()) {
  write_file_atomically(file, kept);
  descriptor_ = ::open(file_.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
  if (descriptor_ < 0) fail(file_, "open for writing");
}

StepLog::~StepLog() {
  try {
    flush();
  } catch (const SceneError&) {
    // Another error is on its way, or flush() was called before and said so.
  }
  if (descriptor_ >= 0) ::close(descriptor_);
}

void StepLog::add(const StepLine& line) {
  pending_ += line_json(line).dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

void StepLog::flush() {
  while (!pending_.empty()) {
    const ssize_t written = ::write(descriptor_, pending_.data(), pending_.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail(file_, "write");
    pending_.erase(0, static_cast<std::size_t>(written));
  }
}

void StepLog::sync() const {
  if (::fsync(descriptor_) != 0) fail(file_, "fsync");
}

std::string read_steps(const std::filesystem::path& file, std::int64_t last_step,
                       const std::function<void(const StepLine&)>& take) {
  std::istringstream lines(bytes_if_readable(file));
  std::string kept;
  std::int64_t previous = 0;
  for (std::string text; std::getline(lines, text);) {
    try {
      const StepLine line = parse_line(text);
      if (line.report.number <= previous || line.report.number > last_step) continue;
      previous = line.report.number;
      take(line);
      kept += text + "\n";
    } catch (const Json::exception&) {
      continue;
    }
  }
  return kept;
}

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
              {"stages_ms", stages_json(totals.stages)},
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
  if (scene.method == "asynchronous")
    report["asynchronous"] = asynchronous_json(totals.asynchronous);
  if (!scene.garment_starts.empty()) report["garments"] = garments_json(scene);
  if (!scene.seams.empty()) report["seams"] = seams_json(simulation.seams());
  if (totals.balance.rows.even > 0) report["balance"] = balance_json(totals.balance);
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
  }
  if (totals.limit_excess) report["limit_excess_max"] = *totals.limit_excess;
  if (totals.sleep.pieces > 0) report["sleep"] = sleep_json(totals, vertices);
  if (totals.remeshes > 0) {
    report["remeshing"] = remesh_json(totals.remesh);
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
