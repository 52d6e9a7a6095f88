// Methods against what makes simulations fail, each case from several jittered starts.
#include <fmt/format.h>
#include <poll.h>
#include <CLI/CLI.hpp>

#include <chrono>
#include <cstdio>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "benchmarks/stability/case.hpp"
#include "benchmarks/stability/isolate.hpp"
#include "benchmarks/support/bench_main.hpp"
#include "host/base/atomic_file.hpp"
#include "weft/error.hpp"

namespace {

using Json = nlohmann::ordered_json;
using weft::stability::Case;
using weft::stability::Child;
using weft::stability::Outcome;
using weft::stability::Setup;

struct Options {
  std::vector<std::string> names;
  std::vector<std::string> methods = weft::stability::methods();
  int jitters = 10;
  int first = 1;
  int jobs = 1;
  double limit = 120;
  std::string device = "cpu:1";
  std::string json;
  bool list = false;
  bool smoke = false;
  bool resume = false;
};

struct Task {
  const Case* what;
  Setup setup;
};

std::vector<Task> tasks_of(const Options& options) {
  std::vector<const Case*> cases;
  for (const std::string& name : options.names) cases.push_back(&weft::stability::find_case(name));
  if (cases.empty() && options.smoke)
    for (const char* name : {"time_step_1_30", "three_on_an_edge", "tangled"})
      cases.push_back(&weft::stability::find_case(name));
  if (cases.empty())
    for (const Case& c : weft::stability::all_cases()) cases.push_back(&c);
  // All cases from one start before the next, so that a run that is cut off has something of each.
  std::vector<Task> tasks;
  const int starts = options.smoke ? 1 : options.jitters;
  for (int seed = options.first; seed < options.first + starts; ++seed)
    for (const Case* c : cases)
      for (const std::string& method : options.methods)
        tasks.push_back({c, {method, static_cast<std::uint64_t>(seed), options.device}});
  return tasks;
}

Json entry_of(const Child& child) {
  const auto verdict = child.verdict();
  return {{"case", child.what().name},  {"method", child.setup().method},
          {"seed", child.setup().seed}, {"outcome", describe(verdict.outcome)},
          {"detail", verdict.detail},   {"wall_s", child.seconds()}};
}

/// Waits until one of the processes has something to say, or a tenth of a second.
void wait_for_any(const std::vector<std::unique_ptr<Child>>& children) {
  std::vector<pollfd> waiting;
  for (const auto& child : children) waiting.push_back({child->descriptor(), POLLIN, 0});
  ::poll(waiting.data(), waiting.size(), 100);
}

void print(const Json& entry) {
  const auto detail = entry["detail"].get<std::string>();
  fmt::print("{:7} {:7.1f} s  {} {} {}{}\n", entry["outcome"].get<std::string>(),
             entry["wall_s"].get<double>(), entry["case"].get<std::string>(),
             entry["method"].get<std::string>(), entry["seed"].get<int>(),
             detail.empty() ? "" : ": " + detail);
  std::fflush(stdout);
}

/// Runs of the file that need not be repeated: by this build, on this machine and device, within
/// this limit, and all of them asked for again, so that none is lost.
/// @return one a task; null: to be run
std::vector<Json> kept_entries(const std::vector<Task>& tasks, const Options& options,
                               const Json& machine) {
  std::vector<Json> entries(tasks.size());
  if (!options.resume) return entries;
  std::ifstream in(options.json);
  const Json before = Json::parse(in, nullptr, false);
  if (!before.is_object()) return entries;
  const Json machine_before = before.value("machine", Json::object());
  if (before.value("build", Json()) != weft::bench::build_json() ||
      machine_before.value("cpu", "") != machine.value("cpu", "") ||
      machine_before.value("threads", 0) != machine.value("threads", 0) ||
      before.value("device", "") != options.device ||
      before.value("limit_s", 0.0) != options.limit || !before.contains("runs"))
    throw weft::SceneError(options.json, "--resume",
                           "runs of another build, machine, device or limit",
                           "a file of the same, or none");
  std::size_t found = 0;
  for (std::size_t k = 0; k < tasks.size(); ++k)
    for (const Json& run : before["runs"])
      if (run.at("case") == tasks[k].what->name && run.at("method") == tasks[k].setup.method &&
          run.at("seed") == tasks[k].setup.seed) {
        entries[k] = run;
        ++found;
      }
  if (found < before["runs"].size())
    throw weft::SceneError(
        options.json, "--resume",
        std::to_string(before["runs"].size() - found) + " runs that are not asked for again",
        "a file of the cases, methods and starts of this call");
  return entries;
}

/// Runs all tasks that have no entry yet, `jobs` at once; entries come in the order of the tasks.
/// @param save called every few seconds with what is done so far; the rest is null
template <class Save>
std::vector<Json> run_all(const std::vector<Task>& tasks, const Options& options,
                          std::vector<Json> entries, const Save& save) {
  using Clock = std::chrono::steady_clock;
  auto saved = Clock::now();
  std::vector<std::unique_ptr<Child>> running;
  std::vector<std::size_t> place;
  for (std::size_t next = 0; next < tasks.size() || !running.empty();) {
    while (next < tasks.size() && running.size() < static_cast<std::size_t>(options.jobs)) {
      if (!entries[next].is_null()) {
        ++next;
        continue;
      }
      running.push_back(
          std::make_unique<Child>(*tasks[next].what, tasks[next].setup, options.limit));
      place.push_back(next++);
    }
    if (running.empty()) break;  // the rest was kept
    wait_for_any(running);
    for (std::size_t k = 0; k < running.size();) {
      if (!running[k]->poll()) {
        ++k;
        continue;
      }
      Json& entry = entries[place[k]] = entry_of(*running[k]);
      print(entry);
      running.erase(running.begin() + static_cast<std::ptrdiff_t>(k));
      place.erase(place.begin() + static_cast<std::ptrdiff_t>(k));
    }
    if (Clock::now() - saved < std::chrono::seconds(5)) continue;
    save(entries);
    saved = Clock::now();
  }
  return entries;
}

Json make_json(const std::vector<Task>& tasks, const std::vector<Json>& entries,
               const Options& options, const std::vector<std::string>& command,
               const Json& machine) {
  Json cases = Json::array();
  for (const Task& task : tasks)
    if (task.setup.seed == tasks.front().setup.seed && task.setup.method == options.methods.front())
      cases.push_back({{"name", task.what->name}, {"about", task.what->about}});
  Json done = Json::array();
  for (const Json& entry : entries)
    if (!entry.is_null()) done.push_back(entry);
  return {{"benchmark", "stability"},
          {"device", options.device},
          {"methods", options.methods},
          {"limit_s", options.limit},
          {"cases", cases},
          {"complete", done.size() == tasks.size()},
          {"runs", done},
          {"command", command},
          {"build", weft::bench::build_json()},
          {"machine", machine},
          {"finished", weft::bench::now_text()}};
}

int run(const Options& options, const std::vector<std::string>& command) {
  if (options.list) {
    for (const Case& c : weft::stability::all_cases()) fmt::print("{}: {}\n", c.name, c.about);
    return weft::bench::done;
  }
  const std::vector<Task> tasks = tasks_of(options);
  const Json machine = weft::bench::machine_json();
  const auto save = [&](const std::vector<Json>& entries) {
    if (!options.json.empty())
      weft::write_file_atomically(
          options.json, make_json(tasks, entries, options, command, machine).dump(2) + "\n");
  };
  const std::vector<Json> entries =
      run_all(tasks, options, kept_entries(tasks, options, machine), save);
  int counts[3] = {};
  for (const Json& entry : entries)
    for (const Outcome outcome : {Outcome::passed, Outcome::refused, Outcome::failed})
      counts[static_cast<int>(outcome)] += entry["outcome"] == describe(outcome) ? 1 : 0;
  fmt::print("{} runs: {} passed, {} refused, {} failed\n", entries.size(), counts[0], counts[1],
             counts[2]);
  save(entries);
  return weft::bench::done;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Runs what simulations fail at, and says of each: passed, refused or failed",
               "weft_bench_stability");
  Options options;
  app.add_option("case", options.names, "Cases; default: all; --list shows them");
  app.add_option("--method", options.methods, "Methods; default: all")
      ->delimiter(',')
      ->allow_extra_args(false);
  app.add_option("--jitters", options.jitters, "Starts a case")->check(CLI::Range(1, 1000));
  app.add_option("--first", options.first, "Number of the first start, so that parts may be joined")
      ->check(CLI::Range(1, 1000000));
  app.add_option("--jobs", options.jobs, "Processes at once")->check(CLI::Range(1, 1024));
  app.add_option("--limit", options.limit, "Seconds a run; what takes longer has failed")
      ->check(CLI::PositiveNumber);
  app.add_option("--device", options.device, "As of weft run");
  auto* json = app.add_option("--json", options.json, "Write all outcomes to this file");
  app.add_flag("--resume", options.resume,
               "Keep the runs that the file has already, of the same build, device and limit")
      ->needs(json);
  app.add_flag("--list", options.list, "Print the cases");
  app.add_flag("--smoke", options.smoke, "One start of some quick cases");
  return weft::bench::bench_main(app, argc, argv, [&](const std::vector<std::string>& command) {
    return run(options, command);
  });
}
