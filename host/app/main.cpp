#include <fmt/format.h>
#include <malloc.h>
#include <signal.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <new>
#include <string>
#include <vector>

#include "host/app/chart/chart.hpp"
#include "host/app/check.hpp"
#include "host/app/convert.hpp"
#include "host/app/info.hpp"
#include "host/app/manual/print_manual.hpp"
#include "host/app/new/new_scene.hpp"
#include "host/app/plan/plan.hpp"
#include "host/app/process/stop_signal.hpp"
#include "host/app/render/render.hpp"
#include "host/app/run.hpp"
#include "host/app/time_parallel/slice_process.hpp"
#include "host/app/view/view.hpp"
#include "host/input/nearest_word.hpp"
#include "host/input/safe_text.hpp"
#include "weft/error.hpp"
#include "weft/version.hpp"

namespace {

enum ExitCode {
  internal_error = 1,
  bad_input = 2,
  device_error = 3,
  simulation_failed = 4,
  stopped = 130
};

/// Says what went wrong in one line.
int fail(std::string message, ExitCode code) {
  while (!message.empty() && message.back() == '\n') message.pop_back();
  std::replace(message.begin(), message.end(), '\n', ' ');
  constexpr std::size_t longest = 2000;
  if (message.size() > longest) message = message.substr(0, longest) + "...";
  message = weft::one_line(message);
  std::fflush(stdout);
  // Does not throw, as fmt::print() does, where standard error cannot be written either.
  std::fputs(fmt::format("weft: {}\n", message).c_str(), stderr);
  return code;
}

/// Most of what a frame or a welded seam frees, the next one needs again: glibc keeps it, so that
/// the system need not clear as many pages.
void keep_freed_memory() {
#ifdef __GLIBC__
  ::mallopt(M_MMAP_THRESHOLD, 32 << 20);
  ::mallopt(M_TRIM_THRESHOLD, 1 << 30);
  ::mallopt(M_TOP_PAD, 64 << 20);
#endif
}

/// "weft 0.2.0 (commit 1234567890ab, with changes)"
std::string version_text() {
  const weft::BuildInfo& build = weft::build_info();
  return fmt::format("weft {} (commit {}{})", build.version,
                     std::string(build.commit).substr(0, 12), build.dirty ? ", with changes" : "");
}

std::vector<std::string> subcommands_of(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* subcommand : app.get_subcommands(nullptr))
    if (!subcommand->get_description().empty()) names.push_back(subcommand->get_name());
  return names;
}

/// What is wrong with words that CLI11 has left over: the first one that looks like an option, or
/// simply the first.
std::string unexpected_word(const CLI::App& app) {
  for (const CLI::App* subcommand : app.get_subcommands()) {
    std::vector<std::string> left = subcommand->remaining();
    if (left.empty()) continue;
    std::reverse(left.begin(), left.end());  // as they were parsed from the back
    const auto option = std::find_if(left.begin(), left.end(),
                                     [](const std::string& word) { return word.starts_with("-"); });
    const std::string& word = option != left.end() ? *option : left.front();
    const std::string name = word.substr(0, word.find('='));
    std::vector<std::string> known;
    for (const CLI::Option* o : subcommand->get_options())
      for (const std::string& known_name : o->get_lnames()) known.push_back("--" + known_name);
    return fmt::format("{0}: {1} is not expected{2}; see weft {0} --help", subcommand->get_name(),
                       word, weft::did_you_mean(name, known));
  }
  return "there are words too many; see weft --help";
}

/// What is wrong with the words, and where to read more.
std::string parse_message(const CLI::App& app, const CLI::ParseError& error) {
  const auto chosen = app.get_subcommands();
  return fmt::format("{}; see weft {}--help", error.what(),
                     chosen.empty() ? "" : chosen.front()->get_name() + " ");
}

/// Output that nobody got is no success.
int flush_output() {
  errno = 0;
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return 0;
  return fail(
      fmt::format("standard output: cannot write: {}", std::strerror(errno != 0 ? errno : EIO)),
      bad_input);
}

/// An empty value, as a script with an unset variable gives it, is never meant.
void refuse_empty_values(CLI::App& app) {
  const CLI::Validator filled(
      [](const std::string& value) {
        return std::string(value.empty() ? "nothing; allowed: a value" : "");
      },
      "");
  for (CLI::App* subcommand : app.get_subcommands(nullptr))
    for (CLI::Option* option : subcommand->get_options())
      if (option->get_items_expected_max() > 0) option->check(filled);
}

/// Whether the first word should be a subcommand and is none.
bool unknown_subcommand(const CLI::App& app, const std::vector<std::string>& words) {
  if (words.empty() || words[0].starts_with('-')) return false;
  const auto subcommands = app.get_subcommands(nullptr);
  return std::none_of(subcommands.begin(), subcommands.end(), [&](const CLI::App* subcommand) {
    return subcommand->get_name() == words[0];
  });
}

/// The words after the program's name; `help run` becomes `run --help`.
std::vector<std::string> words_of(int argc, char** argv) {
  std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
  if (words.empty() || words[0] != "help") return words;
  words.erase(words.begin());
  words.resize(std::min<std::size_t>(words.size(), 1));
  words.emplace_back("--help");
  return words;
}

}  // namespace

int main(int argc, char** argv) {
  keep_freed_memory();
  ::signal(SIGXFSZ, SIG_IGN);  // a file beyond the limit of the shell is an error of its write
  CLI::App app("weft: a cloth engine", "weft");
  app.set_version_flag("--version", version_text());
  app.require_subcommand(1);
  int exit_code = 0;
  weft::app::add_new_subcommand(app, exit_code);
  weft::app::add_run_subcommand(app, exit_code);
  weft::app::add_slice_subcommand(app, exit_code);
  weft::app::add_check_subcommand(app, exit_code);
  weft::app::add_chart_subcommand(app, exit_code);
  weft::app::add_convert_subcommand(app, exit_code);
  weft::app::add_plan_subcommand(app, exit_code);
  weft::app::add_render_subcommand(app, exit_code);
  weft::app::add_view_subcommand(app, exit_code);
  weft::app::add_info_subcommand(app, exit_code);
  weft::app::add_manual_subcommand(app, exit_code);
  refuse_empty_values(app);
  try {
    std::vector<std::string> words = words_of(argc, argv);
    if (unknown_subcommand(app, words))
      return fail(fmt::format("subcommand: {}; allowed: {}{}", words[0],
                              fmt::join(subcommands_of(app), ", "),
                              weft::did_you_mean(words[0], subcommands_of(app))),
                  bad_input);
    std::reverse(words.begin(), words.end());  // CLI11 takes them from the back
    app.parse(words);
    // What a run is for is in its directory.
    return exit_code != 0 || app.got_subcommand("run") ? exit_code : flush_output();
  } catch (const CLI::ExtrasError&) {
    return fail(unexpected_word(app), bad_input);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() != 0) return fail(parse_message(app, error), bad_input);
    app.exit(error);
    return flush_output();
  } catch (const weft::SceneError& error) {
    return fail(error.what(), bad_input);
  } catch (const weft::DeviceError& error) {
    return fail(error.what(), device_error);
  } catch (const weft::SimulationError& error) {
    return fail(error.what(), simulation_failed);
  } catch (const weft::StoppedError&) {
    return fail(weft::app::stop_reason() + " while the simulation was set up; nothing is written",
                stopped);
  } catch (const std::filesystem::filesystem_error& error) {
    return fail(error.what(), bad_input);
  } catch (const std::bad_alloc&) {
    return fail("out of memory", device_error);
  } catch (const std::exception& error) {
    return fail(fmt::format("internal error: {}", error.what()), internal_error);
  }
}
