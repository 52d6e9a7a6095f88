#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace weft {

/// How many characters have to be put in, left out or changed, and neighbours swapped, to make one
/// word of the other (Damerau 1964; no part is edited twice).
std::size_t edit_distance(const std::string& a, const std::string& b);

/// Known word closest to `word`, if it is close enough to be a slip of the keyboard, or begins with
/// it.
std::optional<std::string> nearest_word(const std::string& word,
                                        const std::vector<std::string>& known);

/// "; did you mean "thickness"?", or nothing if no known word is near.
std::string did_you_mean(const std::string& word, const std::vector<std::string>& known);

}  // namespace weft
