#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

/// Tests of the engine against closed forms of mechanics. Each is a function of named parameters;
/// the benchmark weft_bench_physics runs one with any parameters, the suite tests/physics all of
/// them with those of the list. Scenes are made through the public interface alone, in double
/// precision, on one rank.
namespace weft::physics {

/// A parameter of a test as the test declares it.
struct Parameter {
  std::string key;
  std::string value;  ///< default
  std::string about;  ///< unit, meaning, what is allowed
};

/// The parameters of one run, every default filled in.
class Parameters {
 public:
  /// @param declared  what the test takes
  /// @param overrides "key=value" each
  /// @throws SceneError if an override is malformed or names no parameter of the test
  Parameters(std::vector<Parameter> declared, const std::vector<std::string>& overrides);

  /// @throws SceneError unless the value is a finite number
  double number(std::string_view key) const;
  /// @throws SceneError unless the value is a finite number > 0
  double positive(std::string_view key) const;
  /// @throws SceneError unless the value is an integer of min to 1,000,000
  int count(std::string_view key, int min = 1) const;
  const std::string& text(std::string_view key) const;
  /// @throws SceneError unless the value is one of those allowed
  const std::string& one_of(std::string_view key, const std::vector<std::string>& allowed) const;
  bool has(std::string_view key) const;
  const std::vector<Parameter>& all() const { return values_; }

 private:
  std::vector<Parameter> values_;
};

/// What a test found.
struct Outcome {
  double value = 0;
  std::optional<double> reference;  ///< none: only the caller knows it
  std::optional<double> error;      ///< none without reference; never negative
  std::optional<double> tolerance;  ///< largest error that passes; none: not checked
  std::vector<std::pair<std::string, double>> more;  ///< other figures, by name

  bool passes() const { return !tolerance || (error && *error <= *tolerance); }
};

/// |value / reference - 1| against a tolerance.
Outcome relative(double value, double reference, double tolerance);
/// |value - reference| against a tolerance.
Outcome absolute(double value, double reference, double tolerance);
/// A value that has no reference here.
Outcome unjudged(double value);

struct Test {
  std::string name;
  std::string about;  ///< what the value is and where the reference comes from, one line
  std::vector<Parameter> parameters;
  Outcome (*run)(const Parameters&);
};

/// All tests, in the order of the table that they fill.
const std::vector<Test>& all_tests();

/// @throws SceneError if there is no test of that name
const Test& find_test(std::string_view name);

/// Why a test is known to miss its tolerance with these parameters; null: it is not.
const char* known_miss(std::string_view name, const Parameters& parameters);

/// Joins lists of parameters.
std::vector<Parameter> operator+(std::vector<Parameter> a, const std::vector<Parameter>& b);

std::vector<Test> integrator_tests();
std::vector<Test> flight_tests();
std::vector<Test> membrane_tests();
std::vector<Test> hanging_tests();
std::vector<Test> falling_tests();
std::vector<Test> friction_tests();
std::vector<Test> elastica_tests();
std::vector<Test> plate_tests();
std::vector<Test> stick_slip_tests();
std::vector<Test> buckling_tests();
std::vector<Test> balloon_tests();
std::vector<Test> drape_tests();

}  // namespace weft::physics
