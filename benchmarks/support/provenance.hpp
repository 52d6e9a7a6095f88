#pragma once

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "weft/version.hpp"

/// Where the figures of a benchmark come from: what every result says of build, machine and
/// command.
namespace weft::bench {

/// Now, in UTC, as in 2026-01-31T12:00:00Z.
inline std::string now_text() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  char text[32] = "";
  if (gmtime_r(&now, &utc) != nullptr) std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

/// The processor's name, "unknown" where the system does not tell.
inline std::string cpu_model() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("model name"))
      if (const auto colon = line.find(": "); colon != std::string::npos)
        return line.substr(colon + 2);
  return "unknown";
}

/// Where and when; load averages show whether the machine was free. Taken before the runs.
inline nlohmann::ordered_json machine_json() {
  double load[3] = {};
  nlohmann::ordered_json loads = nullptr;
  if (getloadavg(load, 3) == 3) loads = {load[0], load[1], load[2]};
  return {{"cpu", cpu_model()},
          {"threads", std::thread::hardware_concurrency()},
          {"load_average_before", loads},
          {"started", now_text()}};
}

inline nlohmann::ordered_json build_json() {
  const BuildInfo& build = build_info();
  return {{"version", build.version},   {"commit", build.commit}, {"dirty", build.dirty},
          {"compiler", build.compiler}, {"cuda", build.cuda},     {"build_type", build.build_type}};
}

/// The command as anyone could type it: of the program, and of files with an absolute path, which
/// mean nothing elsewhere, the names alone.
inline std::vector<std::string> command_words(int argc, const char* const* argv) {
  std::vector<std::string> words;
  for (int k = 0; k < argc; ++k) {
    const std::string word = argv[k];
    const auto value = word.starts_with("--") ? word.find('=') + 1 : 0;  // of --key=value
    const std::filesystem::path path = word.substr(value);
    words.push_back(k == 0 || path.is_absolute() ? word.substr(0, value) + path.filename().string()
                                                 : word);
  }
  return words;
}

/// JSON with the names of files in the place of absolute paths, which belong to one machine.
inline nlohmann::json without_folders(nlohmann::json json) {
  if (json.is_string()) {
    const std::filesystem::path path = json.get<std::string>();
    if (path.is_absolute()) json = path.filename().string();
  } else if (json.is_structured()) {
    for (auto& part : json) part = without_folders(part);
  }
  return json;
}

}  // namespace weft::bench
