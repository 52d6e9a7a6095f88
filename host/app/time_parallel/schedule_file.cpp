#include "host/app/time_parallel/schedule_file.hpp"

#include <algorithm>
#include <string>

#include "host/app/run/json_archive.hpp"
#include "host/base/atomic_file.hpp"
#include "host/base/file_bytes.hpp"
#include "weft/error.hpp"

namespace weft::app {

namespace fs = std::filesystem;

static void fields(JsonArchive& io, ScheduleFile& schedule) {
  io("steps", schedule.steps);
  io("slices", schedule.slices);
  io("complete", schedule.complete);
  io("starts", schedule.starts);
}

std::optional<ScheduleFile> ScheduleFile::read(const fs::path& file) {
  try {
    return read_fields<ScheduleFile>(Json::parse(bytes_if_readable(file)), {"slices"});
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

ScheduleFile ScheduleFile::read_whole(const fs::path& file, std::int64_t steps) {
  const auto refuse = [&](const std::string& field, const std::string& value,
                          const std::string& allowed) {
    throw SceneError(file.string(), field, value, allowed);
  };
  ScheduleFile schedule;
  try {
    schedule = read_fields<ScheduleFile>(Json::parse(bytes_if_readable(file)),
                                         {"steps", "starts", "complete"});
  } catch (const Json::exception& error) {
    refuse("partition", error.what(), "what a run wrote as partition.json");
  }
  if (schedule.steps != steps)
    refuse("steps", std::to_string(schedule.steps),
           "the " + std::to_string(steps) + " steps of this run");
  if (!schedule.complete)
    refuse("complete", "false", "the partition of a run whose slices were all decided");
  if (schedule.starts.empty()) refuse("starts", "none", "at least one");
  return schedule;
}

void ScheduleFile::write(const fs::path& file) const {
  write_file_atomically(file, json_of(*this).dump(2) + "\n");
}

bool ScheduleFile::begins(const std::vector<std::int64_t>& others) const {
  return starts.size() <= others.size() && std::equal(starts.begin(), starts.end(), others.begin());
}

}  // namespace weft::app
