#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

namespace weft::app {

/// partition.json: where the slices of a run begin.
struct ScheduleFile {
  std::int64_t steps = 0;            ///< of the run
  int slices = 0;                    ///< in the end
  bool complete = false;             ///< all are decided
  std::vector<std::int64_t> starts;  ///< [step] of those that are

  /// @return nothing if there is none that makes sense
  static std::optional<ScheduleFile> read(const std::filesystem::path& file);
  /// Of `--partition`.
  /// @param steps of the run
  /// @throws SceneError unless it is of so many steps, and all of its slices are decided
  static ScheduleFile read_whole(const std::filesystem::path& file, std::int64_t steps);
  void write(const std::filesystem::path& file) const;

  /// Whether those of another schedule begin as these.
  bool begins(const std::vector<std::int64_t>& others) const;
};

}  // namespace weft::app
