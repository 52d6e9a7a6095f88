#pragma once

#include <cstddef>
#include <string>
#include <string_view>

/// Names and other text from files, made safe for the place that they are written to. Files come
/// from strangers: such text must never be run, end a string early, or move a cursor.
namespace weft {

/// One line of valid UTF-8 that a terminal shows as it is. Control characters, characters that
/// change the direction of text or are not seen, and bytes that are no UTF-8 become '?'.
std::string one_line(std::string_view text);

/// The beginning of a text in quotation marks, for messages: printable ASCII, and '?' for the rest.
/// @param most bytes that are shown
std::string quoted_start(std::string_view text, std::size_t most = 60);

bool is_control(char c);
/// With '?' for control characters.
std::string without_controls(std::string text);

/// A part of a path: never empty, ".", or "..", no separator, no '.' or '-' in front, at most 100
/// bytes. Letters of any script, ASCII digits, spaces and _-. stay; other characters become '_'.
std::string safe_file_name(std::string_view text);

/// one_line() as a text of gnuplot, with its quotation marks; those within become typographic ones.
/// Nothing in it is substituted.
std::string gnuplot_text(std::string_view text);

/// one_line() as a cell of CSV, with its quotation marks. A spreadsheet takes it for a text, never
/// for a formula.
std::string csv_text(std::string_view text);

/// JSON as a value within a <script> of HTML: nothing in it ends the script or begins a comment.
std::string script_json(std::string_view json);

/// one_line() as a name in OBJ, where a backslash at the end would join the next line.
std::string obj_name(std::string_view text);

/// one_line() as a text of USD, with its quotation marks.
std::string usd_text(std::string_view text);

}  // namespace weft
