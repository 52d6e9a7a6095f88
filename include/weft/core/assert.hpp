#pragma once

#include <cassert>

/// Checks an invariant of the program itself, never of its input. On unless NDEBUG is set.
#define WEFT_ASSERT(condition) assert(condition)
