#include "host/app/plan/small_runs.hpp"

#include <fmt/format.h>

#include <utility>

#include "host/app/chart/accuracy_target.hpp"
#include "host/app/process/child.hpp"

namespace weft::app {

SmallRuns::SmallRuns(const Scene& scene, SceneRequest request)
    : request_(std::move(request)), triangles_(static_cast<double>(triangle_count(scene))) {}

bool SmallRuns::reducible(double triangles) const {
  return takes_triangles(request_, triangles);
}

const SmallRuns::Run& SmallRuns::run(double triangles, const std::vector<std::string>& settings) {
  std::vector<std::string> all = settings;
  if (triangles > 0) all.insert(all.begin(), fmt::format("triangles={:.0f}", triangles));
  std::vector<std::string> words =
      request_.command({"run", request_.scene, "--device", "cpu:1", "--no-preview"}, all);
  const auto found = done_.find(words);
  if (found != done_.end()) return found->second;
  Run& made = done_[words];
  const std::string output = (scratch_.path() / std::to_string(done_.size())).string();
  words.insert(words.end(), {"-o", output});
  const ChildEnd end = run_child(words, output + ".log", seconds_max);
  if (end.timed_out)
    made.problem = fmt::format("takes longer than {:g} s", seconds_max);
  else if (end.exit_code != 0)
    made.problem = end.message;
  else
    made.folder = output;
  return made;
}

}  // namespace weft::app
