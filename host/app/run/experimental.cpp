#include "host/app/run/experimental.hpp"

#include <CLI/CLI.hpp>

#include "host/io/scene/scene_file.hpp"

namespace weft::app {

void add_experimental(CLI::App& subcommand, std::vector<std::string>& values) {
  subcommand
      .add_option("--experimental", values,
                  "Set a value for tests and comparisons that is no key of scenes; may be repeated")
      ->type_name("PATH=VALUE")
      ->allow_extra_args(false);
}

std::vector<std::string> experimental_words(const std::vector<std::string>& values) {
  std::vector<std::string> words;
  for (const std::string& text : values) words.insert(words.end(), {"--experimental", text});
  return words;
}

std::vector<std::string> setting_words(const std::vector<std::string>& values) {
  std::vector<std::string> words;
  for (const std::string& text : values) {
    const bool hidden = io::is_experimental(text.substr(0, text.find('=')));
    words.insert(words.end(), {hidden ? "--experimental" : "--set", text});
  }
  return words;
}

}  // namespace weft::app
