#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "host/app/chart/chart_points.hpp"
#include "host/app/chart/chart_progress.hpp"
#include "host/lab/chart/compare.hpp"

namespace weft::app {

/// What all points are measured against.
struct ChartReference {
  Mesh mesh;                                      ///< of all cloths, at the start
  std::vector<std::vector<Vec3<double>>> frames;  ///< [frame][vertex] [m], the first at the start
  double size = 1;                                ///< [m] diagonal of the start
  int horizon = 0;  ///< last frame before chaos: errors are of frames 1 to this one
  std::vector<lab::MeanStatistics> after;  ///< of the frames after it, over all starts
  double floor = 0;    ///< how far two independent references differ, over the diagonal
  std::string source;  ///< how it was made, one line
  std::string chaos;   ///< how the horizon was found, one line

  /// Share of the frames after the horizon.
  double after_chaos() const {
    return static_cast<double>(after.size()) / static_cast<double>(frames.size() - 1);
  }
};

/// Runs of one scene, in a folder of their own.
class ChartRuns {
 public:
  ChartRuns(std::filesystem::path folder, const ChartRequest& request);

  /// Makes the reference, or takes over what an earlier sweep has made, and shows its progress.
  /// @param scene as it is without any knob turned
  /// @throws SimulationError if no reference can be made
  ChartReference make_reference(const Scene& scene) const;

  /// A point with what is known of it before it is run: setting, command, commit.
  ChartPoint unmeasured(const ChartSetting& setting) const;

  /// Runs a point as often as asked for and measures it; it never throws for a run that fails.
  /// Several threads may measure at once, each in a slot of its own.
  /// @param cores that the runs may use; empty: any
  ChartPoint measure(const ChartSetting& setting, const ChartReference& reference, int slot = 0,
                     const std::vector<int>& cores = {}) const;

  /// The command of a run, without program and output folder.
  std::vector<std::string> arguments(const std::string& device,
                                     const std::vector<std::string>& overrides) const;

 private:
  std::string run(const std::filesystem::path& output, const std::string& device,
                  const std::vector<std::string>& overrides,
                  const std::vector<int>& cores = {}) const;
  /// A run that the reference is made of.
  struct ReferenceRun {
    std::string name;  ///< of its folder
    std::vector<std::string> overrides;
  };
  std::vector<ReferenceRun> reference_runs(const Scene& scene) const;
  void run_reference(const ReferenceRun& reference, ChartProgress& progress) const;
  void run_references(const Scene& scene) const;
  void find_horizon(const Scene& scene, ChartReference& reference) const;
  std::vector<std::string> start_overrides(double size, int start) const;
  void measure_starts(const ChartReference& reference, const std::filesystem::path& output,
                      const std::vector<int>& cores,
                      std::vector<std::vector<lab::Statistics>> of_starts, ChartPoint& point) const;

  std::filesystem::path folder_;
  const ChartRequest& request_;
};

/// Mean over the frames of the mean distance of two runs of one scene, over the diagonal of the
/// first at its start; on whatever meshes.
/// @throws SimulationError if the runs have nothing in common
double run_distance(const std::filesystem::path& reference, const std::filesystem::path& run);

/// Intersections in all frames of a run, by the independent validator.
double run_intersections(const std::filesystem::path& run);

/// Where every vertex is at `time` if that can be told: one cloth that starts flat, unstretched and
/// at one velocity, and falls through the void. Nothing otherwise.
std::optional<std::vector<Vec3<double>>> free_fall(const Scene& scene, double time);

}  // namespace weft::app
