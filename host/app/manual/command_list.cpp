#include "host/app/manual/command_list.hpp"

#include <CLI/CLI.hpp>

namespace weft::app {
namespace {

/// "{a,b,c}" as CLI11 describes a choice.
std::vector<std::string> choices_of(const std::string& type) {
  const std::size_t open = type.find('{'), close = type.rfind('}');
  std::vector<std::string> choices;
  if (open == std::string::npos || close == std::string::npos || close < open) return choices;
  std::string word;
  for (const char c : type.substr(open + 1, close - open - 1)) {
    if (c != ',') {
      word += c;
      continue;
    }
    choices.push_back(word);
    word.clear();
  }
  if (!word.empty()) choices.push_back(word);
  return choices;
}

CommandOption option_of(const CLI::Option& option) {
  CommandOption result;
  for (const std::string& name : option.get_snames()) result.words.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) result.words.push_back("--" + name);
  result.description = option.get_description();
  result.required = option.get_required();
  if (result.words.empty()) result.argument = option.get_name(true);
  if (option.get_items_expected_max() == 0) return result;
  result.value = option.get_type_name();
  result.choices = choices_of(result.value);
  if (!result.choices.empty() || result.value.empty()) result.value = "VALUE";
  // What follows a colon is CLI11's text of a check.
  if (const std::size_t colon = result.value.find(':'); colon != std::string::npos)
    result.value.resize(colon);
  result.fallback = option.get_default_str();
  return result;
}

Command command_of(const CLI::App& app) {
  Command command{app.get_name(), app.get_description(), {}};
  for (const CLI::Option* option : app.get_options())
    if (!option->get_group().empty()) command.options.push_back(option_of(*option));
  return command;
}

}  // namespace

std::vector<Command> command_list(const CLI::App& app) {
  std::vector<Command> commands{command_of(app)};
  for (const CLI::App* subcommand : app.get_subcommands(nullptr))
    if (!subcommand->get_group().empty()) commands.push_back(command_of(*subcommand));
  return commands;
}

}  // namespace weft::app
