#pragma once

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "benchmarks/support/provenance.hpp"
#include "weft/error.hpp"

namespace weft::bench {

/// What a benchmark's process says at its end.
enum ExitCode {
  done = 0,
  wrong_result = 1,
  bad_input = 2,
  device_error = 3,
  simulation_failed = 4
};

/// Reads the command line and runs the benchmark; an exception becomes a line and an exit code.
/// @param run takes the command, for the result, and returns an ExitCode
template <class Run>
int bench_main(CLI::App& app, int argc, char** argv, const Run& run) {
  const auto fail = [&](const std::exception& error, ExitCode code) -> int {
    std::fflush(stdout);
    fmt::print(stderr, "{}: {}\n", app.get_name(), error.what());
    return code;
  };
  try {
    app.parse(argc, argv);
    return run(command_words(argc, argv));
  } catch (const CLI::ParseError& error) {
    return error.get_exit_code() == 0 ? app.exit(error) : fail(error, bad_input);
  } catch (const SceneError& error) {
    return fail(error, bad_input);
  } catch (const DeviceError& error) {
    return fail(error, device_error);
  } catch (const SimulationError& error) {
    return fail(error, simulation_failed);
  } catch (const std::exception& error) {
    return fail(error, wrong_result);
  }
}

}  // namespace weft::bench
