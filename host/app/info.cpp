#include "host/app/info.hpp"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <memory>
#include <string_view>
#include <thread>

#include "host/scene/fabric/fabrics.hpp"
#include "weft/devices.hpp"
#include "weft/error.hpp"
#include "weft/version.hpp"

namespace weft::app {
namespace {

void print_fabrics() {
  for (const Fabric& f : fabrics()) {
    const OrthotropicStretch& s = *f.material.orthotropic;
    const OrthotropicBending& b = *f.material.orthotropic_bending;
    fmt::print("{}: {}{}\n", f.name, f.description,
               f.name == std::string_view(default_fabric) ? " (of cloth that names none)" : "");
    fmt::print("  {} kg/m^2; stretch {}, {} N/m, Poisson's ratio {}, shear {} N/m\n",
               f.material.density, s.warp, s.weft, s.poisson_ratio, s.shear);
    fmt::print("  bending {}, {} N m, twist {} N m\n", b.warp, b.weft, b.twist);
    fmt::print("  {}{}\n", f.estimate ? "" : "after ", f.source);
  }
}

/// What GPUs measure of each other; one that cannot be measured is no reason to say less of the
/// rest.
void print_links() {
  try {
    const auto links = describe_links();
    if (!links.empty()) fmt::print("links\n");
    for (const auto& line : links) fmt::print("  {}\n", line);
  } catch (const DeviceError& error) {
    fmt::print("links: {}\n", error.what());
  }
}

}  // namespace

void add_info_subcommand(CLI::App& app, int& exit_code) {
  auto* subcommand = app.add_subcommand("info", "Show version, build and devices");
  const auto list_fabrics = std::make_shared<bool>(false);
  subcommand->add_flag("--fabrics", *list_fabrics,
                       "List the fabrics that materials may name, and sources");
  subcommand->callback([&exit_code, list_fabrics] {
    if (*list_fabrics) {
      print_fabrics();
      exit_code = 0;
      return;
    }
    const BuildInfo& build = build_info();
    const bool cuda = !std::string_view(build.cuda).empty();
    fmt::print("weft {}\n", build.version);
    fmt::print("commit    {}{}\n", build.commit, build.dirty ? ", with changes" : "");
    fmt::print("compiler  {}, {}\n", build.compiler, build.build_type);
    fmt::print("CUDA      {}\n", cuda ? fmt::format("yes, {}", build.cuda) : "no");
    fmt::print("threads   {}\n", std::thread::hardware_concurrency());
    fmt::print("devices\n");
    for (const auto& line : describe_devices()) fmt::print("  {}\n", line);
    print_links();
    exit_code = 0;
  });
}

}  // namespace weft::app
