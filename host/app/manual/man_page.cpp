#include "host/app/manual/man_page.hpp"

#include <fmt/format.h>

#include "weft/version.hpp"

namespace weft::app {
namespace {

/// As text: no line of it is a request, and hyphens are those of the keyboard.
std::string roff(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '\\') {
      result += "\\e";
    } else if (c == '-') {
      result += "\\-";
    } else {
      result += c;
    }
  }
  if (result.starts_with('.') || result.starts_with('\'')) result.insert(0, "\\&");
  return result;
}

/// Bold words, the value in italics.
std::string heading(const CommandOption& option) {
  if (option.words.empty()) return "\\fI" + roff(option.argument) + "\\fR";
  std::string text;
  for (const std::string& word : option.words)
    text += (text.empty() ? "" : ", ") + ("\\fB" + roff(word) + "\\fR");
  if (!option.value.empty()) text += " \\fI" + roff(option.value) + "\\fR";
  return text;
}

std::string choices_text(const CommandOption& option) {
  std::string text;
  for (const std::string& choice : option.choices) text += (text.empty() ? "" : ", ") + choice;
  return text.empty() ? "" : " One of: " + text + ".";
}

std::string option_text(const CommandOption& option) {
  std::string text = option.description + "." + choices_text(option);
  if (!option.fallback.empty()) text += " Default: " + option.fallback + ".";
  return fmt::format(".TP\n{}\n{}\n", heading(option), roff(text));
}

std::string synopsis(const Command& command) {
  std::string text = ".B weft " + roff(command.name) + "\n";
  for (const CommandOption& option : command.options)
    if (option.words.empty())
      text += option.required ? "\\fI" + roff(option.argument) + "\\fR\n"
                              : "[\\fI" + roff(option.argument) + "\\fR]\n";
  return text + "[\\fIoptions\\fR]\n.br\n";
}

struct Code {
  int number;
  const char* meaning;
};

constexpr Code codes[] = {
    {0, "done"},
    {1,
     "weft check found something that displaced bodies do not explain; in other subcommands a bug"},
    {2, "bad input, or a file that cannot be read or written"},
    {3, "a device is missing or lost, or memory is exhausted"},
    {4, "the simulation failed, a seam did not close, or an accuracy target was missed"},
    {130, "stopped by a signal or by --time-limit"},
};

}  // namespace

std::string man_page(const std::vector<Command>& commands) {
  std::string text = fmt::format(
      ".\\\" Made from the program's own options.\n"
      ".TH WEFT 1 \"\" \"weft {}\" \"User Commands\"\n"
      ".SH NAME\nweft \\- simulate cloth\n.SH SYNOPSIS\n",
      WEFT_VERSION);
  for (std::size_t c = 1; c < commands.size(); ++c) text += synopsis(commands[c]);
  text +=
      ".SH DESCRIPTION\n"
      "weft simulates cloth: garments on moving bodies, flags, towels, stacks of layers. No frame "
      "that it writes contains an intersection.\n"
      ".PP\n"
      "\\fBweft new\\fR writes a scene for meshes, \\fBweft run\\fR simulates it, \\fBweft "
      "check\\fR tests the frames, and \\fBweft render\\fR draws them.\n";
  text += ".SH OPTIONS\n";
  for (const CommandOption& option : commands[0].options) text += option_text(option);
  text += ".SH COMMANDS\n";
  for (std::size_t c = 1; c < commands.size(); ++c) {
    text +=
        fmt::format(".SS weft {}\n{}.\n", roff(commands[c].name), roff(commands[c].description));
    for (const CommandOption& option : commands[c].options) text += option_text(option);
  }
  text += ".SH EXIT STATUS\n";
  for (const Code& code : codes)
    text += fmt::format(".TP\n{}\n{}\n", code.number, roff(code.meaning));
  text +=
      ".SH EXAMPLE\n.nf\n"
      "weft new cloth.obj body.obj\n"
      "weft run scene.json \\-o out/mine\n"
      "weft check out/mine\n"
      "weft render out/mine\n.fi\n";
  return text;
}

}  // namespace weft::app
