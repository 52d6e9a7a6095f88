#include "host/app/manual/completion.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace weft::app {
namespace {

/// In single quotation marks, for any shell.
std::string quoted(const std::string& text, const char* mark) {
  std::string result = "'";
  for (const char c : text) result += c == '\'' ? std::string(mark) : std::string(1, c);
  return result + "'";
}
std::string for_sh(const std::string& text) {
  return quoted(text, "'\\''");
}
std::string for_fish(const std::string& text) {
  std::string escaped;
  for (const char c : text) escaped += c == '\\' ? std::string("\\\\") : std::string(1, c);
  return quoted(escaped, "\\'");
}

/// zsh reads ':' and brackets in descriptions.
std::string for_zsh(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == ':' || c == '[' || c == ']' || c == '\\') escaped += '\\';
    escaped += c;
  }
  return escaped;
}

/// Candidates for a value.
enum class Values { choices, folders, files };

Values values_of(const CommandOption& option) {
  if (!option.choices.empty()) return Values::choices;
  return option.value == "DIR" ? Values::folders : Values::files;
}

bool is_flag(const CommandOption& option) {
  return option.value.empty();
}

}  // namespace

std::string bash_completion(const std::vector<Command>& commands) {
  std::string text =
      "# Completion of weft for bash, made from the program's own options.\n"
      "_weft() {\n"
      "  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]}\n"
      "  local command=${COMP_WORDS[1]}\n"
      "  COMPREPLY=()\n";
  std::vector<std::string> names;
  for (std::size_t c = 1; c < commands.size(); ++c) names.push_back(commands[c].name);
  std::vector<std::string> own;
  for (const CommandOption& option : commands[0].options)
    own.insert(own.end(), option.words.begin(), option.words.end());
  text += fmt::format(
      "  if ((COMP_CWORD == 1)); then\n"
      "    mapfile -t COMPREPLY < <(compgen -W {} -- \"$word\")\n"
      "    return\n"
      "  fi\n"
      "  case $command in\n",
      for_sh(fmt::format("{} {}", fmt::join(names, " "), fmt::join(own, " "))));
  for (std::size_t c = 1; c < commands.size(); ++c) {
    std::vector<std::string> words;
    text += fmt::format("    {})\n      case $before in\n", commands[c].name);
    for (const CommandOption& option : commands[c].options) {
      words.insert(words.end(), option.words.begin(), option.words.end());
      if (is_flag(option) || option.words.empty()) continue;
      const Values values = values_of(option);
      text += fmt::format("        {})\n", fmt::join(option.words, "|"));
      if (values == Values::choices)
        text += fmt::format("          mapfile -t COMPREPLY < <(compgen -W {} -- \"$word\")\n",
                            for_sh(fmt::format("{}", fmt::join(option.choices, " "))));
      else
        text += fmt::format("          mapfile -t COMPREPLY < <(compgen -{} -- \"$word\")\n",
                            values == Values::folders ? 'd' : 'f');
      text += "          return ;;\n";
    }
    text += fmt::format(
        "      esac\n"
        "      if [[ $word == -* ]]; then\n"
        "        mapfile -t COMPREPLY < <(compgen -W {} -- \"$word\")\n"
        "      else\n"
        "        mapfile -t COMPREPLY < <(compgen -f -- \"$word\")\n"
        "      fi ;;\n",
        for_sh(fmt::format("{}", fmt::join(words, " "))));
  }
  text +=
      "  esac\n"
      "}\n"
      "complete -o filenames -F _weft weft\n";
  return text;
}

std::string zsh_completion(const std::vector<Command>& commands) {
  std::string text =
      "#compdef weft\n"
      "# Completion of weft for zsh, made from the program's own options.\n"
      "_weft() {\n"
      "  local -a commands\n"
      "  commands=(\n";
  for (std::size_t c = 1; c < commands.size(); ++c)
    text +=
        "    " + for_sh(for_zsh(commands[c].name) + ":" + for_zsh(commands[c].description)) + "\n";
  text +=
      "  )\n"
      "  if ((CURRENT == 2)); then\n"
      "    _describe command commands\n"
      "    return\n"
      "  fi\n"
      "  local command=$words[2]\n"
      "  shift words\n"
      "  ((CURRENT--))\n"
      "  case $command in\n";
  for (std::size_t c = 1; c < commands.size(); ++c) {
    text += fmt::format("    {})\n      _arguments", commands[c].name);
    for (const CommandOption& option : commands[c].options) {
      std::string action;
      if (!is_flag(option)) {
        const Values values = values_of(option);
        action = fmt::format(":{}:{}", for_zsh(option.value),
                             values == Values::choices
                                 ? fmt::format("({})", fmt::join(option.choices, " "))
                             : values == Values::folders ? "_files -/"
                                                         : "_files");
      }
      if (option.words.empty()) continue;
      for (const std::string& word : option.words)
        text +=
            " \\\n        " + for_sh("*" + word + "[" + for_zsh(option.description) + "]" + action);
    }
    text += " \\\n        '*:file:_files' ;;\n";
  }
  text +=
      "  esac\n"
      "}\n"
      "_weft \"$@\"\n";
  return text;
}

std::string fish_completion(const std::vector<Command>& commands) {
  std::string text = "# Completion of weft for fish, made from the program's own options.\n";
  for (std::size_t c = 0; c < commands.size(); ++c) {
    const Command& command = commands[c];
    const std::string here =
        c == 0 ? "__fish_use_subcommand" : "__fish_seen_subcommand_from " + command.name;
    if (c > 0)
      text += fmt::format("complete -c weft -n __fish_use_subcommand -f -a {} -d {}\n",
                          command.name, for_fish(command.description));
    for (const CommandOption& option : command.options) {
      if (option.words.empty()) continue;
      text += fmt::format("complete -c weft -n {}", for_fish(here));
      for (const std::string& word : option.words)
        text += word.starts_with("--") ? " -l " + word.substr(2) : " -s " + word.substr(1);
      if (!is_flag(option)) text += " -r";
      if (!option.choices.empty())
        text += " -f -a " + for_fish(fmt::format("{}", fmt::join(option.choices, " ")));
      text += " -d " + for_fish(option.description) + "\n";
    }
  }
  return text;
}

}  // namespace weft::app
