#include "host/app/render/frame_choice.hpp"

#include <CLI/CLI.hpp>

#include <fmt/format.h>

#include <regex>

#include "weft/error.hpp"

namespace weft::app {

void add_shown_frames(CLI::App& subcommand, std::string& input, std::string& frames) {
  subcommand
      .add_option("input", input,
                  "Directory of a run; or an animation (.usda, .pc2), numbered meshes "
                  "(DIR/%05d.obj), a mesh")
      ->required()
      ->type_name("DIR");
  subcommand
      .add_option("--frames", frames, "Which frames, both ends included, or last; default: all")
      ->type_name("A:B[:STEP]");
}

std::vector<std::size_t> chosen_frames(const std::vector<int>& numbers, const std::string& text) {
  static const std::regex pattern(R"((\d{1,9})|(\d{0,9}):(\d{0,9})(?::(\d{1,9}))?)");
  if (text == "last") return {numbers.size() - 1};
  const std::string there =
      numbers.size() == 1
          ? fmt::format("frame {}", numbers.front())
          : fmt::format("{} frames from {} to {}", numbers.size(), numbers.front(), numbers.back());
  std::smatch match;
  if (!text.empty() && !std::regex_match(text, match, pattern))
    throw SceneError("", "--frames", text, "A, A:B, A:B:STEP or last; there are " + there);
  const auto number = [&](std::size_t group, int fallback) {
    return match.size() > group && match[group].length() > 0 ? std::stoi(match[group]) : fallback;
  };
  const bool single = match.size() > 1 && match[1].matched;
  const int first = single ? number(1, 0) : number(2, numbers.front());
  const int last = single ? first : number(3, numbers.back());
  const int step = number(4, 1);
  std::vector<std::size_t> places;
  for (std::size_t k = 0; k < numbers.size(); ++k)
    if (step > 0 && numbers[k] >= first && numbers[k] <= last && (numbers[k] - first) % step == 0)
      places.push_back(k);
  if (places.empty()) throw SceneError("", "--frames", text, "some of the " + there);
  return places;
}

}  // namespace weft::app
