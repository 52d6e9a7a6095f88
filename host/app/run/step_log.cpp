#include "host/app/run/step_log.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <sstream>
#include <string_view>
#include <utility>

#include "host/app/run/report_fields.hpp"
#include "host/base/atomic_file.hpp"
#include "host/base/file_bytes.hpp"
#include "host/base/file_operations.hpp"
#include "weft/error.hpp"

namespace weft::app {

static void fields(JsonArchive& io, StepLine& line) {
  StepReport& r = line.report;
  io("number", r.number);
  io("time", r.time);
  io("step", r.step);
  io("wall_s", line.wall);
  io("solves", r.solves);
  io("iterations", r.iterations);
  io("iterations_max", r.iterations_max);
  io("residual_max", r.residual_max);
  io("newton_iterations", r.newton_iterations);
  io("newton_residual", r.newton_residual);
  io("line_steps", r.line_steps);
  io("active_set_iterations", r.active_set_iterations);
  io("searches", r.searches);
  io("self_certified", r.self_certified);
  io.ms("certificate_ms", r.certificate_seconds);
  io("face_pairs", r.face_pairs);
  io("edge_pairs", r.edge_pairs);
  io("proximities", r.proximities);
  io("impacts", r.impacts);
  io("ccd_tests", r.ccd_tests);
  io("zone_rounds", r.zone_rounds);
  io("zones", r.zones);
  io("zone_largest", r.zone_largest);
  io("zone_passes", r.zone_passes);
  io("zone_visits", r.zone_visits);
  io("zones_unsolved", r.zones_unsolved);
  io("plane_zones", r.plane_zones);
  io("rigid_zones", r.rigid_zones);
  io("truncations", r.truncations);
  io("fallback_level", r.fallback_level);
  io("compliant", r.compliant);
  io("compliance_distance", r.compliance_distance);
  io("retries", r.retries);
  io("rebuilds", r.rebuilds);
  io("open_seam_pairs", r.open_seam_pairs);
  io("allocations", r.allocations);
  io("synchronisations", r.synchronisations);
  io("failure", r.failure);
  io("failure_detail", r.failure_detail);
  io("stages_ms", r.stages);
  io("step_error", r.step_error);
  io.only_if(r.step_error.has_value(), "rejected", r.rejected);
  io("work", r.work);
  io("limit_excess", r.limit_excess);
  io("moving_share", r.moving_share);
  io("failure_place", r.failure_place);
  io.only_if(r.resolve_collisions.total() > 0, "resolve_collisions_ms", r.resolve_collisions);
  io.only_if(r.asynchronous.windows > 0, "asynchronous", r.asynchronous);
  io.only_if(r.remesh.triangles > 0, "remesh", r.remesh);
  io.only_if(r.sleep.pieces > 0, "sleep", r.sleep);
  io.only_if(r.balance.rows.even > 0, "balance", r.balance);
  io("energy", line.energy);
}

/// @throws Json::exception if the line is none of ours
static StepLine parse_line(std::string_view text) {
  return read_fields<StepLine>(Json::parse(text), {"number", "time", "stages_ms"});
}

StepLog::StepLog(const std::filesystem::path& file, const std::string& kept)
    : file_(file.string()) {
  write_file_atomically(file, kept);
  descriptor_ = ::open(file_.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
  if (descriptor_ < 0) fail_on(file_, "open for writing");
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
  pending_ += json_of(line).dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

void StepLog::flush() {
  write_all(file_, descriptor_, std::exchange(pending_, {}));
}

void StepLog::sync() const {
  if (::fsync(descriptor_) != 0) fail_on(file_, "fsync");
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

}  // namespace weft::app
