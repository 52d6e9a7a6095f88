#include "host/time_parallel/spin_up.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "host/time_parallel/slice_start.hpp"
#include "weft/devices.hpp"
#include "weft/error.hpp"
#include "weft/simulation.hpp"

namespace weft {

std::vector<std::int64_t> spin_up_starts(std::int64_t step, double steps_a_coarse) {
  constexpr double rounding = 1e-9;
  const double place = static_cast<double>(step) / steps_a_coarse;
  const auto after = static_cast<std::int64_t>(std::ceil(place - rounding));
  std::vector<std::int64_t> starts{step};
  for (std::int64_t back = 1; starts.back() > 0; back *= 2) {
    const auto coarse = static_cast<double>(std::max<std::int64_t>(0, after - back));
    const auto start = static_cast<std::int64_t>(std::ceil(coarse * steps_a_coarse - rounding));
    if (start < starts.back()) starts.push_back(start);
  }
  return starts;
}

bool spin_up(const Scene& fine, const std::filesystem::path& from, std::int64_t step,
             const std::filesystem::path& file, const std::function<bool(double work)>& took) {
  Simulation simulation(fine, host_devices(1));
  if (!from.empty()) simulation.resume(from, SceneChanges::allow);
  double work = 0;
  while (simulation.step_number() < step) {
    if (!took(work)) return false;
    const std::int64_t rows = cloth_rows(simulation.scene());
    const StepReport report = simulation.step();
    if (report.failure != Failure::none)
      throw SimulationError("step " + std::to_string(report.number) +
                            " on the way to the start of a slice: " + describe(report.failure) +
                            (report.failure_detail.empty() ? "" : ": " + report.failure_detail));
    work = counted_work(report, rows);
  }
  if (!took(work)) return false;
  simulation.save(file);
  return true;
}

}  // namespace weft
