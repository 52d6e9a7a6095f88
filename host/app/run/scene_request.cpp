#include "host/app/run/scene_request.hpp"

#include <CLI/CLI.hpp>

#include "host/app/run/allow_path.hpp"

namespace weft::app {

void SceneRequest::add_options(CLI::App& subcommand) {
  subcommand.add_option("--set", overrides, "Override a value of the scene; may be repeated")
      ->type_name("PATH=VALUE")
      ->allow_extra_args(false);
  subcommand
      .add_option("--experimental", experimental,
                  "Set a value for tests and comparisons that is no key of scenes; may be repeated")
      ->type_name("PATH=VALUE")
      ->allow_extra_args(false);
  add_allow_path(subcommand, allowed);
}

Scene SceneRequest::read() const {
  return io::read_scene(scene, overrides, allowed, experimental);
}

std::vector<std::string> SceneRequest::command(std::vector<std::string> words,
                                               const std::vector<std::string>& more) const {
  for (const auto& list : {allow_path_words(allowed), setting_words(experimental),
                           setting_words(overrides), setting_words(more)})
    words.insert(words.end(), list.begin(), list.end());
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
