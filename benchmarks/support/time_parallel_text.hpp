#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <string>

#include "benchmarks/support/time_parallel_json.hpp"

/// What weft_bench_time_parallel prints of what it writes.
namespace weft::bench {

/// A line on one run in slices, as of run_json().
inline void print_run(const Json& run) {
  const Json& clock = run.at("by_clock");
  const Json& work = run.at("by_counted_work");
  const auto of = [](const Json& j, const char* key) {
    return j.contains(key) ? j.at(key).get<double>() : 0.0;
  };
  const Json& seams = run.at("seams");
  const char* key = "position_over_largest_frame_change";
  const std::string of_frames =
      seams.contains(key)
          ? fmt::format(", {:.2f} of the largest frame change", seams.at(key).get<double>())
          : std::string();
  fmt::print(
      "{:<9} {:>4} slices, {} at once: {:8.2f} s, {:5.2f}x measured; a core each: {:5.2f}x by "
      "clock ({:3.0f} % of eq. 16), {:5.2f}x by work ({:3.0f} %); largest seam jump "
      "{:.4f} m{}\n",
      run.at("partition").get<std::string>(), run.at("slices").get<int>(),
      run.at("workers_at_once").get<int>(), run.at("wall_s").get<double>(),
      run.at("speedup_measured").get<double>(), of(clock, "speedup_with_a_core_each"),
      100 * of(clock, "efficiency"), of(work, "speedup_with_a_core_each"),
      100 * of(work, "efficiency"), seams.at("position_max_m").get<double>(), of_frames);
  std::fflush(stdout);
}

/// A line on one state, as of Accuracy.
inline void print_accuracy(const Json& row) {
  const auto of = [&](const char* key) {
    if (!row.contains(key) || !row.at(key).contains("curvature")) return std::string("-");
    return fmt::format("{:.3f} ({:.1f} % dihedral, {:.2f} of the angles, {:.1f} mm)",
                       row.at(key).at("curvature").get<double>(),
                       100 * row.at(key).at("dihedral").get<double>(),
                       row.at(key).at("angles_over_serial").get<double>(),
                       1e3 * row.at(key).at("position_rms_m").get<double>());
  };
  fmt::print(
      "{:6.3f} s, eq. (17): before {}, after {}; from averages: before {}, after {}; twin {}\n",
      row.at("time_s").get<double>(), of("before"), of("after"), of("before_from_averages"),
      of("after_from_averages"), of("twin"));
  std::fflush(stdout);
}

}  // namespace weft::bench
