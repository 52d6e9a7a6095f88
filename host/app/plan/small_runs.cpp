#include "host/app/plan/small_runs.hpp"

#include <fmt/format.h>

#include <utility>

#include "host/app/chart/accuracy_target.hpp"
#include "host/app/process/child.hpp"
#include "host/app/run/allow_path.hpp"
#include "host/app/run/experimental.hpp"

namespace weft::app {

SmallRuns::SmallRuns(const Scene& scene, std::string file, std::vector<std::string> overrides,
                     std::vector<std::string> allowed, std::vector<std::string> experimental)
    : file_(std::move(file)),
      overrides_(std::move(overrides)),
      allowed_(std::move(allowed)),
      experimental_(std::move(experimental)) {
  for (const Cloth& cloth : scene.cloths)
    triangles_ += static_cast<double>(cloth.mesh.triangles.size());
}

bool SmallRuns::reducible(double triangles) const {
  return takes_triangles(file_, overrides_, allowed_, experimental_, triangles);
}

const SmallRuns::Run& SmallRuns::run(double triangles, const std::vector<std::string>& settings) {
  std::vector<std::string> words{"run", file_, "--device", "cpu:1", "--no-preview"};
  const std::vector<std::string> allowed = allow_path_words(allowed_);
  words.insert(words.end(), allowed.begin(), allowed.end());
  const std::vector<std::string> experimental = experimental_words(experimental_);
  words.insert(words.end(), experimental.begin(), experimental.end());
  for (const std::string& text : overrides_) words.insert(words.end(), {"--set", text});
  if (triangles > 0)
    words.insert(words.end(), {"--set", fmt::format("triangles={:.0f}", triangles)});
  const std::vector<std::string> set = setting_words(settings);
  words.insert(words.end(), set.begin(), set.end());
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
