#include "host/app/info.hpp"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <cstdio>
#include <string_view>
#include <thread>

#include "weft/devices.hpp"
#include "weft/version.hpp"

namespace weft::app {

void add_info_verb(CLI::App& app, int& exit_code) {
  auto* verb = app.add_subcommand("info", "Show version, build and devices");
  verb->callback([&exit_code] {
    const BuildInfo& build = build_info();
    const bool cuda = !std::string_view(build.cuda).empty();
    fmt::print("weft {}\n", build.version);
    fmt::print("commit    {}{}\n", build.commit, build.dirty ? ", with changes" : "");
    fmt::print("compiler  {}, {}\n", build.compiler, build.build_type);
    fmt::print("CUDA      {}\n", cuda ? fmt::format("yes, {}", build.cuda) : "no");
    fmt::print("threads   {}\n", std::thread::hardware_concurrency());
    fmt::print("devices\n");
    for (const auto& line : describe_devices()) fmt::print("  {}\n", line);
    exit_code = 0;
  });
}

}  // namespace weft::app
