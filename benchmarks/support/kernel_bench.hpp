#pragma once

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <iostream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "weft/devices.hpp"
#include "weft/error.hpp"
#include "weft/exec/describe.hpp"
#include "weft/version.hpp"

/// What the benchmarks of kernels share. It takes nothing but the standard library, so that they
/// build on machines that have little else.
namespace weft::bench {

/// An object or an array of JSON, written as it grows.
class Json {
 public:
  explicit Json(char open = '{') : open_(open) {}
  Json& add(std::string_view name, double value) {
    std::ostringstream number;
    number.precision(6);
    number << value;
    return put(name, number.str());
  }
  Json& add(std::string_view name, std::string_view value) {
    std::string quoted = "\"";
    for (const char c : value)
      quoted += c == '"' || c == '\\' ? std::string{'\\', c} : std::string{c};
    return put(name, quoted + "\"");
  }
  Json& add(std::string_view name, const char* value) { return add(name, std::string_view(value)); }
  Json& add(std::string_view name, const Json& value) { return put(name, value.text()); }
  /// To an array.
  Json& add(const Json& value) { return put({}, value.text()); }
  std::string text() const { return open_ + members_ + (open_ == '{' ? "}" : "]"); }

 private:
  Json& put(std::string_view name, const std::string& value) {
    if (!members_.empty()) members_ += open_ == '{' ? ", " : ",\n  ";
    if (open_ == '{') members_ += "\"" + std::string(name) + "\": ";
    members_ += value;
    return *this;
  }
  char open_;
  std::string members_;
};

struct Options {
  std::string device = "cpu:1";
  std::vector<int> vertices;  ///< about so many
  std::string json;
  bool smoke = false;
};

/// @throws SceneError naming the argument that it cannot read
inline Options parse(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; ++i) {
    const std::string_view name = argv[i];
    if (name == "--smoke") {
      options.smoke = true;
      continue;
    }
    if (i + 1 == argc || (name != "--device" && name != "--vertices" && name != "--json"))
      throw SceneError("", "argument", std::string(name),
                       "--device D, --vertices N (repeatable), --json FILE, --smoke");
    const std::string value = argv[++i];
    if (name == "--device") options.device = value;
    if (name == "--vertices") options.vertices.push_back(std::stoi(value));
    if (name == "--json") options.json = value;
  }
  if (options.smoke && options.vertices.empty()) options.vertices = {1000};
  if (options.vertices.empty()) options.vertices = {130'000, 500'000, 1'000'000};
  return options;
}

/// Shortest wall time of a few calls [s]; `call` leaves no work under way.
template <class Call>
double shortest(int repeats, const Call& call) {
  double best = 1e300;
  for (int i = 0; i < repeats; ++i) {
    const auto start = std::chrono::steady_clock::now();
    call();
    best = std::min(
        best, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  return best;
}

/// Benchmark, build, machine and results, as a file.
inline void write(const Options& options, std::string_view benchmark, const Json& results) {
  if (options.json.empty()) return;
  const BuildInfo& b = build_info();
  const std::time_t now = std::time(nullptr);
  char started[32] = "";
  std::tm utc{};
  if (gmtime_r(&now, &utc) != nullptr)
    std::strftime(started, sizeof started, "%Y-%m-%dT%H:%M:%SZ", &utc);
  Json build, machine, all;
  build.add("version", b.version).add("commit", b.commit).add("dirty", b.dirty ? 1.0 : 0.0);
  build.add("compiler", b.compiler).add("cuda", b.cuda).add("build_type", b.build_type);
  Json devices('[');
  // Asked once: copies are measured for it.
  static const std::vector<std::string> lines = describe_devices();
  for (const std::string& line : lines) devices.add(Json().add("device", line));
  machine.add("devices", devices).add("time", started);
  all.add("benchmark", benchmark).add("build", build).add("machine", machine);
  all.add("results", results);
  // By another name first: a program that is stopped leaves the file of before.
  const std::string part = options.json + ".part";
  std::ofstream(part) << all.text() << "\n";
  if (std::rename(part.c_str(), options.json.c_str()) != 0)
    throw std::runtime_error(options.json + ": cannot be written");
}

/// Runs `body(options)` as a program's main does: 1 for a wrong result, 2 for bad arguments, 3 for
/// the device.
template <class Body>
int run(int argc, char** argv, const Body& body) {
  try {
    body(parse(argc, argv));
    return 0;
  } catch (const SceneError& error) {
    std::cerr << argv[0] << ": " << error.what() << "\n";
    return 2;
  } catch (const DeviceError& error) {
    std::cerr << argv[0] << ": " << error.what() << "\n";
    return 3;
  } catch (const std::exception& error) {
    std::cerr << argv[0] << ": " << error.what() << "\n";
    return 1;
  }
}

}  // namespace weft::bench
