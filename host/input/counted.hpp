#pragma once

#include <cstdint>
#include <string>

namespace weft {

/// A noun in the number that goes with `count`.
inline std::string noun_for(std::int64_t count, std::string noun) {
  if (count == 1) return noun;
  if (noun.ends_with("vertex")) return noun.replace(noun.size() - 2, 2, "ices");
  return noun + (noun.ends_with("ch") ? "es" : "s");
}

/// Such as "1 vertex" or "3 vertices".
template <class Count>
std::string counted(Count count, const std::string& noun) {
  return std::to_string(count) + " " + noun_for(static_cast<std::int64_t>(count), noun);
}

}  // namespace weft
