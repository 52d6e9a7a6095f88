#pragma once

#include <cstdint>
#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

/// Runs at which methods fail: each ends right, or is refused with a name. What is left over -
/// a NaN, an intersection that nobody reported, a wrong result, a crash, no end - is a failure.
/// The benchmark weft_bench_stability runs them from jittered starts, the suite tests/stability
/// from one.
namespace weft::stability {

/// How a case is to be run.
struct Setup {
  std::string method = "implicit";  ///< as method.type
  std::uint64_t seed = 1;           ///< of the start's jitter
  std::string device = "cpu:1";     ///< as --device
};

enum class Outcome {
  passed,   ///< what the case asks for, to its tolerance
  refused,  ///< an error that says what is wrong, and a state that is still finite
  failed,   ///< anything else
};

/// "passed", "refused" or "failed".
const char* describe(Outcome outcome);

struct Verdict {
  Outcome outcome = Outcome::failed;
  std::string detail;  ///< why, one line; empty if passed
};

/// The result is not what it should be.
class Wrong : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct Case {
  std::string name;
  std::string about;  ///< what happens, and what has to hold at the end; one line
  /// Returns if the result is right.
  /// @throws Wrong if it is not; SceneError, DeviceError, SimulationError where it is refused
  std::function<void(const Setup&)> run;
};

/// Methods that run the suite.
const std::vector<std::string>& methods();

/// All cases, in the order of the table that they fill.
const std::vector<Case>& all_cases();

/// @throws SceneError if there is no case of that name
const Case& find_case(std::string_view name);

/// Runs a case in this process.
Verdict judge(const Case& c, const Setup& setup);

/// Why a case is known to fail with a method; null: it is not.
const char* known_failure(std::string_view name, std::string_view method);

/// Whether a case is known to take more than a minute with a method, so that it may not end in
/// time.
bool takes_long(std::string_view name, std::string_view method);

std::vector<Case> motion_cases();
std::vector<Case> contrast_cases();
std::vector<Case> folding_cases();
std::vector<Case> mesh_cases();
std::vector<Case> invariance_cases();
std::vector<Case> input_cases();
std::vector<Case> fault_cases();

}  // namespace weft::stability
