#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace weft::app {

/// Adds the frames to show: the positional `input`, a run, an animation or meshes, and `--frames`.
/// @param input,frames must outlive the parsing
void add_shown_frames(CLI::App& subcommand, std::string& input, std::string& frames);

/// Places among `numbers` that the value of `--frames` asks for: "A", "A:B" or "A:B:STEP"; A and B
/// may be left out.
/// @param numbers of the frames that there are, increasing; at least one
/// @param text    empty: all
/// @throws SceneError if it asks for nothing, or is something else
std::vector<std::size_t> chosen_frames(const std::vector<int>& numbers, const std::string& text);

}  // namespace weft::app
