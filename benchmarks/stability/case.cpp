#include "benchmarks/stability/case.hpp"

#include <algorithm>
#include <exception>
#include <utility>

#include "weft/error.hpp"

namespace weft::stability {

const char* describe(Outcome outcome) {
  switch (outcome) {
    case Outcome::passed:
      return "passed";
    case Outcome::refused:
      return "refused";
    case Outcome::failed:
      return "failed";
  }
  return "unknown";
}

const std::vector<std::string>& methods() {
  static const std::vector<std::string> names{"implicit", "adaptive", "view", "asynchronous",
                                              "time_parallel"};
  return names;
}

const std::vector<Case>& all_cases() {
  static const std::vector<Case> cases = [] {
    std::vector<Case> all;
    for (auto part : {motion_cases, contrast_cases, folding_cases, mesh_cases, invariance_cases,
                      input_cases, fault_cases})
      for (Case& c : part()) all.push_back(std::move(c));
    return all;
  }();
  return cases;
}

const Case& find_case(std::string_view name) {
  const auto& cases = all_cases();
  const auto found =
      std::find_if(cases.begin(), cases.end(), [&](const Case& c) { return c.name == name; });
  if (found != cases.end()) return *found;
  std::string names;
  for (const Case& c : cases) names += (names.empty() ? "" : ", ") + c.name;
  throw SceneError("", "case", std::string(name), "one of " + names);
}

Verdict judge(const Case& c, const Setup& setup) {
  try {
    c.run(setup);
    return {Outcome::passed, {}};
  } catch (const Wrong& error) {
    return {Outcome::failed, error.what()};
  } catch (const SceneError& error) {
    return {Outcome::refused, error.what()};
  } catch (const DeviceError& error) {
    return {Outcome::refused, error.what()};
  } catch (const SimulationError& error) {
    return {Outcome::refused, error.what()};
  } catch (const std::exception& error) {
    return {Outcome::failed, std::string("an error of no declared kind: ") + error.what()};
  }
}

}  // namespace weft::stability
