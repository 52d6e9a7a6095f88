#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace weft::app {

/// How a run of this program ended.
struct ChildEnd {
  int exit_code = -1;  ///< minus the signal that ended it
  bool timed_out = false;
  std::string message;  ///< last line on standard error, without the program's name
};

/// Runs this program with other arguments and waits for it; its output goes to files.
/// @param arguments without the program's name
/// @param log       its standard output and error go here, one after the other's name
/// @param limit     [s] after which it is killed; 0: none
/// @param cores     that it may use, as the system numbers them; empty: any
/// @throws SceneError if it cannot be started or `log` cannot be written
ChildEnd run_child(const std::vector<std::string>& arguments, const std::filesystem::path& log,
                   double limit, const std::vector<int>& cores = {});

/// Runs another program in a folder, without a shell, and waits for it. It has no input.
/// @param words its name, looked for in PATH, and its arguments
/// @param log   its standard output and error go here; its last line is the message
/// @return nothing if there is no such program
/// @throws SceneError if it cannot be started
std::optional<ChildEnd> run_program(std::vector<std::string> words,
                                    const std::filesystem::path& folder,
                                    const std::filesystem::path& log);

/// Words as main() gets them: pointers to them, and a null one. They must outlive these.
std::vector<char*> argument_list(std::vector<std::string>& words);

/// The cores that this process may use, in groups of one size; fewer groups if there are fewer
/// cores.
std::vector<std::vector<int>> core_groups(int count);

/// A command as one would type it.
std::string shell_text(const std::vector<std::string>& words);

}  // namespace weft::app
