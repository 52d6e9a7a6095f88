#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "host/time_parallel/slice_run.hpp"

namespace CLI {
class App;
}

namespace weft::app {

/// Simulates a slice in another process of this program, which is replaced if it is killed: what it
/// had on the disk is gone on with.
/// @param scene   scene.json of the run
/// @param folders of the files that the scene names
/// @param device  for parse_devices()
/// @param frame   called after frames were kept
/// @throws SceneError, DeviceError, SimulationError that ended the process, with its message
SliceOutcome run_slice_process(const std::filesystem::path& scene,
                               const std::vector<std::string>& folders, const std::string& device,
                               const SliceTask& task, SliceGate& gate,
                               const std::function<void()>& frame);

/// Adds `weft slice`, which such a process runs; not for people. It talks as slice_talk.hpp says,
/// by its standard input and output.
void add_slice_subcommand(CLI::App& app, int& exit_code);

}  // namespace weft::app
