#pragma once

#include "weft/core/hd.hpp"

// What impact zones have done to a vertex lately, in one byte: the highest bit says whether they
// moved it in the last step; the others hold its level, which rises with each step that jams it and
// falls in others. Contacts of the vertex resist further closing by the factor of the level.

namespace weft {

inline constexpr int touched_in_last_step = 0x80;
/// Levels up for a step that jams the vertex: twice the factor. Another step lowers the level by
/// one, an eighth of that. Chosen in docs/decisions/002-contacts.md, as is the largest
/// level, a factor of 128.
inline constexpr int level_rise = 8;
inline constexpr int level_max = 56;

WEFT_HD constexpr bool was_touched(unsigned char touched) noexcept {
  return touched >= touched_in_last_step;
}
WEFT_HD constexpr int touched_level(unsigned char touched) noexcept {
  return touched & (touched_in_last_step - 1);
}

/// Factor of a level, 1 to 128: powers of two, and straight lines between them.
/// @param level 0 to level_max
template <class T>
WEFT_HD constexpr T hardening(int level) noexcept {
  return static_cast<T>((level_rise + level % level_rise) << level / level_rise) /
         static_cast<T>(level_rise);
}

/// Vertices whose levels a step may raise.
enum class Hardening : unsigned char {
  none,
  jammed,   ///< those that have a level, if zones moved them or contacts of theirs are crushed, and
            ///< those of crushed contacts that have another vertex with a level
  crushed,  ///< also all of crushed contacts
  all       ///< also all that zones moved
};

/// The byte after another step.
/// @param before its value one step ago
/// @param moved  whether a zone moved the vertex in this step
/// @param jammed whether the step jammed it
WEFT_HD constexpr unsigned char touched_after(unsigned char before, bool moved,
                                              bool jammed) noexcept {
  const int level = touched_level(before);
  int now = level > 0 ? level - 1 : 0;
  if (jammed) now = level + level_rise < level_max ? level + level_rise : level_max;
  return static_cast<unsigned char>(now | (moved ? touched_in_last_step : 0));
}

}  // namespace weft
