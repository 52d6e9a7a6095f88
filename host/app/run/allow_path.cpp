#include "host/app/run/allow_path.hpp"

#include <CLI/CLI.hpp>

namespace weft::app {

void add_allow_path(CLI::App& subcommand, std::vector<std::string>& folders) {
  subcommand
      .add_option("--allow-path", folders,
                  "Folder below which files may lie that a scene or a mesh names, beside its own; "
                  "may be repeated")
      ->type_name("DIR")
      ->allow_extra_args(false);
}

std::vector<std::string> allow_path_words(const std::vector<std::string>& folders) {
  std::vector<std::string> words;
  for (const std::string& folder : folders) words.insert(words.end(), {"--allow-path", folder});
  return words;
}

}  // namespace weft::app
