// One test of the physics with any parameters: prints value, reference and error.
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <chrono>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "benchmarks/physics/test.hpp"
#include "benchmarks/support/bench_main.hpp"
#include "host/base/atomic_file.hpp"
#include "weft/error.hpp"

namespace {

using Json = nlohmann::ordered_json;
using weft::physics::Outcome;
using weft::physics::Parameters;
using weft::physics::Test;

struct Options {
  std::string name;
  std::vector<std::string> overrides;
  std::string json;
  bool list = false;
  bool smoke = false;
};

Json or_null(const std::optional<double>& number) {
  return number ? Json(*number) : Json(nullptr);
}

std::string or_null_text(const std::optional<double>& number) {
  return number ? fmt::format("{:.9g}", *number) : "null";
}

Json make_json(const Test& test, const Parameters& parameters, const Outcome& outcome,
               const std::vector<std::string>& command, const Json& machine, double seconds) {
  Json values = Json::object();
  for (const auto& p : parameters.all()) values[p.key] = p.value;
  Json more = Json::object();
  for (const auto& [key, number] : outcome.more) more[key] = number;
  const char* reason = weft::physics::known_miss(test.name, parameters);
  return {{"benchmark", "physics"},
          {"test", test.name},
          {"about", test.about},
          {"parameters", values},
          {"value", outcome.value},
          {"reference", or_null(outcome.reference)},
          {"error", or_null(outcome.error)},
          {"tolerance", or_null(outcome.tolerance)},
          {"passes", outcome.passes()},
          {"known_miss", reason != nullptr ? Json(reason) : Json(nullptr)},
          {"more", more},
          {"wall_s", seconds},
          {"command", command},
          {"build", weft::bench::build_json()},
          {"machine", machine},
          {"finished", weft::bench::now_text()}};
}

void print_list(const std::string& name) {
  for (const Test& test : weft::physics::all_tests()) {
    if (!name.empty() && test.name != name) continue;
    fmt::print("{}: {}\n", test.name, test.about);
    for (const auto& p : test.parameters)
      fmt::print("  {}={}{}{}\n", p.key, p.value, p.about.empty() ? "" : "  ", p.about);
  }
}

int run(const Options& options, const std::vector<std::string>& command) {
  if (!options.name.empty()) weft::physics::find_test(options.name);
  if (options.list) {
    print_list(options.name);
    return weft::bench::done;
  }
  // The quickest test there is shows that the program runs.
  const Test& test =
      weft::physics::find_test(options.name.empty() && options.smoke ? "free_fall" : options.name);
  const Parameters parameters(test.parameters, options.overrides);
  const Json machine = weft::bench::machine_json();
  const auto begin = std::chrono::steady_clock::now();
  const Outcome outcome = test.run(parameters);
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  fmt::print("{:.9g} {} {}\n", outcome.value, or_null_text(outcome.reference),
             outcome.error ? fmt::format("{:.3g}", *outcome.error) : "null");
  if (!options.json.empty())
    weft::write_file_atomically(
        options.json,
        make_json(test, parameters, outcome, command, machine, seconds).dump(2) + "\n");
  return weft::bench::done;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("A test of the engine against a closed form: prints value, reference and error",
               "weft_bench_physics");
  Options options;
  app.add_option("name", options.name, "Test; --list shows all");
  app.add_option("--set", options.overrides, "Set a parameter of the test; may be repeated")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  app.add_option("--json", options.json, "Write all figures to this file");
  app.add_flag("--list", options.list, "Print the tests, or one, with their parameters");
  app.add_flag("--smoke", options.smoke, "Without a name: the quickest test");
  return weft::bench::bench_main(app, argc, argv, [&](const std::vector<std::string>& command) {
    return run(options, command);
  });
}
