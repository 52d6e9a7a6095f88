#include "host/app/view/run_facts.hpp"

#include <cstdint>
#include <limits>
#include <string>

#include "host/app/run/run_directory.hpp"
#include "host/base/file_bytes.hpp"
#include "host/input/safe_text.hpp"

namespace weft::app {
namespace {

using Json = nlohmann::ordered_json;

void take_text(Json& facts, const Json& report, const char* key) {
  if (report.contains(key) && report[key].is_string())
    facts[key] = one_line(report[key].get<std::string>());
}

void take_number(Json& facts, const Json& report, const char* key) {
  if (report.contains(key) && report[key].is_number()) facts[key] = report[key];
}

}  // namespace

Json step_fields() {
  return {"number",
          "time",
          "step",
          "wall_s",
          "solves",
          "iterations",
          "contacts",
          "impacts",
          "zones",
          "retries",
          "compliance_distance",
          "fallback_level"};
}

Json step_facts(const StepLine& line) {
  const StepReport& r = line.report;
  return {r.number,
          r.time,
          r.step,
          line.wall,
          r.solves,
          r.iterations,
          r.proximities,
          r.impacts,
          r.zones,
          r.retries,
          r.compliance_distance,
          static_cast<int>(r.fallback_level)};
}

Json run_facts(const std::filesystem::path& directory) {
  const RunDirectory run(directory);
  Json facts = Json::object();
  const Json report = Json::parse(bytes_if_readable(run.report()), nullptr, false);
  if (report.is_object()) {
    for (const char* key : {"scene", "method", "device", "precision", "failure"})
      take_text(facts, report, key);
    for (const char* key : {"wall_s", "simulated_s", "steps", "intersections", "triangle_count"})
      take_number(facts, report, key);
    if (report.contains("build") && report["build"].is_object())
      take_text(facts, report["build"], "commit");
  }
  facts["step_fields"] = step_fields();
  Json steps = Json::array();
  read_steps(run.steps(), std::numeric_limits<std::int64_t>::max(),
             [&](const StepLine& line) { steps.push_back(step_facts(line)); });
  facts["steps"] = std::move(steps);
  return facts;
}

}  // namespace weft::app
