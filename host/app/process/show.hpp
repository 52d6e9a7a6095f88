#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <string>
#include <utility>

namespace weft::app {

/// Writes text for whoever watches a run. That nobody can read it is no reason to lose the run: a
/// broken pipe asks it to stop at its next safe point, every other error is ignored.
void show_text(std::FILE* out, const std::string& text);

/// The same with fmt's formats.
template <class... Args>
void show(std::FILE* out, fmt::format_string<Args...> format, Args&&... args) {
  show_text(out, fmt::format(format, std::forward<Args>(args)...));
}

}  // namespace weft::app
