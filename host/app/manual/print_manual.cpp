#include "host/app/manual/print_manual.hpp"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <memory>
#include <string>

#include "host/app/manual/command_list.hpp"
#include "host/app/manual/completion.hpp"
#include "host/app/manual/man_page.hpp"

namespace weft::app {

void add_manual_subcommand(CLI::App& app, int& exit_code) {
  auto* subcommand = app.add_subcommand("manual", "");
  subcommand->group("");
  const auto kind = std::make_shared<std::string>();
  subcommand->add_option("kind", *kind)
      ->required()
      ->check(CLI::IsMember({"bash", "zsh", "fish", "man"}));
  subcommand->callback([&app, &exit_code, kind] {
    const std::vector<Command> commands = command_list(app);
    fmt::print("{}", *kind == "bash"   ? bash_completion(commands)
                     : *kind == "zsh"  ? zsh_completion(commands)
                     : *kind == "fish" ? fish_completion(commands)
                                       : man_page(commands));
    exit_code = 0;
  });
}

}  // namespace weft::app
