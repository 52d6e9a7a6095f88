#include "benchmarks/physics/test.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>

#include "weft/error.hpp"

namespace weft::physics {
namespace {

template <class Values>
auto find_key(Values& values, std::string_view key) {
  return std::find_if(values.begin(), values.end(),
                      [&](const Parameter& p) { return p.key == key; });
}

std::string keys_of(const std::vector<Parameter>& values) {
  std::string keys;
  for (const Parameter& p : values) keys += (keys.empty() ? "" : ", ") + p.key;
  return keys;
}

void append(std::vector<Test>& all, std::vector<Test> tests) {
  for (Test& test : tests) all.push_back(std::move(test));
}

}  // namespace

Parameters::Parameters(std::vector<Parameter> declared, const std::vector<std::string>& overrides)
    : values_(std::move(declared)) {
  for (const std::string& text : overrides) {
    const auto equals = text.find('=');
    if (equals == std::string::npos) throw SceneError("", "--set", text, "key=value");
    const auto found = find_key(values_, std::string_view(text).substr(0, equals));
    if (found == values_.end())
      throw SceneError("", "--set", text.substr(0, equals), "one of " + keys_of(values_));
    found->value = text.substr(equals + 1);
  }
}

double Parameters::number(std::string_view key) const {
  const std::string& value = text(key);
  double number = 0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
  if (error != std::errc() || end != value.data() + value.size() || !std::isfinite(number))
    throw SceneError("", std::string(key), value, "a finite number");
  return number;
}

double Parameters::positive(std::string_view key) const {
  const double value = number(key);
  if (!(value > 0)) throw SceneError("", std::string(key), text(key), "a number > 0");
  return value;
}

int Parameters::count(std::string_view key, int min) const {
  const double value = number(key);
  if (value != std::floor(value) || value < min || value > 1e6)
    throw SceneError("", std::string(key), text(key),
                     fmt::format("an integer of {} to 1000000", min));
  return static_cast<int>(value);
}

const std::string& Parameters::text(std::string_view key) const {
  const auto found = find_key(values_, key);
  if (found == values_.end()) throw SceneError("", "--set", std::string(key), keys_of(values_));
  return found->value;
}

const std::string& Parameters::one_of(std::string_view key,
                                      const std::vector<std::string>& allowed) const {
  const std::string& value = text(key);
  if (std::find(allowed.begin(), allowed.end(), value) == allowed.end())
    throw SceneError("", std::string(key), value, fmt::format("{}", fmt::join(allowed, ", ")));
  return value;
}

bool Parameters::has(std::string_view key) const {
  return find_key(values_, key) != values_.end();
}

Outcome relative(double value, double reference, double tolerance) {
  return {value, reference, std::abs(value / reference - 1), tolerance, {}};
}

Outcome absolute(double value, double reference, double tolerance) {
  return {value, reference, std::abs(value - reference), tolerance, {}};
}

Outcome unjudged(double value) {
  return {value, {}, {}, {}, {}};
}

const std::vector<Test>& all_tests() {
  static const std::vector<Test> tests = [] {
    std::vector<Test> all;
    append(all, integrator_tests());
    append(all, flight_tests());
    append(all, membrane_tests());
    append(all, balloon_tests());
    append(all, hanging_tests());
    append(all, falling_tests());
    append(all, friction_tests());
    append(all, stick_slip_tests());
    append(all, elastica_tests());
    append(all, plate_tests());
    append(all, buckling_tests());
    append(all, drape_tests());
    return all;
  }();
  return tests;
}

const Test& find_test(std::string_view name) {
  std::string names;
  for (const Test& test : all_tests()) {
    if (test.name == name) return test;
    names += (names.empty() ? "" : ", ") + test.name;
  }
  throw SceneError("", "test", std::string(name), "one of " + names);
}

std::vector<Parameter> operator+(std::vector<Parameter> a, const std::vector<Parameter>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

}  // namespace weft::physics
