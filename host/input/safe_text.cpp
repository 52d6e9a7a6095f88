#include "host/input/safe_text.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace weft {
namespace {

constexpr std::size_t max_file_name = 100;  // bytes; most file systems allow 255

/// A character, or a byte that is none.
struct Character {
  std::string_view bytes;
  std::uint32_t code = 0;
  bool valid = false;
};

/// The first character of a text that is not empty (RFC 3629).
Character first_of(std::string_view text) {
  const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(text[k]); };
  const unsigned char lead = byte(0);
  if (lead < 0x80) return {text.substr(0, 1), lead, true};
  const std::size_t size = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : 2;
  constexpr std::array<std::uint32_t, 5> least{0, 0, 0x80, 0x800, 0x10000};
  std::uint32_t code = lead & (0xffu >> (size + 1));
  bool valid = lead >= 0xc2 && lead <= 0xf4 && text.size() >= size;
  for (std::size_t k = 1; valid && k < size; ++k) {
    valid = (byte(k) & 0xc0u) == 0x80;
    code = code << 6 | (byte(k) & 0x3fu);
  }
  valid = valid && code >= least[size] && code <= 0x10ffff && !(code >= 0xd800 && code <= 0xdfff);
  if (!valid) return {text.substr(0, 1), 0, false};
  return {text.substr(0, size), code, true};
}

struct CodeRange {
  std::uint32_t first, last;
};

bool is_among(std::uint32_t code, const CodeRange* begin, const CodeRange* end) {
  return std::any_of(begin, end,
                     [&](const CodeRange& r) { return code >= r.first && code <= r.last; });
}

/// Control and format characters, line separators, what is not seen or is no character.
bool is_hidden(std::uint32_t code) {
  constexpr std::array ranges{
      CodeRange{0x00, 0x1f},       CodeRange{0x7f, 0x9f},     CodeRange{0xad, 0xad},
      CodeRange{0x34f, 0x34f},     CodeRange{0x61c, 0x61c},   CodeRange{0x115f, 0x1160},
      CodeRange{0x17b4, 0x17b5},   CodeRange{0x180b, 0x180f}, CodeRange{0x200b, 0x200f},
      CodeRange{0x2028, 0x202e},   CodeRange{0x2060, 0x206f}, CodeRange{0x3164, 0x3164},
      CodeRange{0xe000, 0xf8ff},   CodeRange{0xfdd0, 0xfdef}, CodeRange{0xfe00, 0xfe0f},
      CodeRange{0xfeff, 0xfeff},   CodeRange{0xffa0, 0xffa0}, CodeRange{0xfff0, 0xffff},
      CodeRange{0xe0000, 0x10ffff}};
  return is_among(code, ranges.data(), ranges.data() + ranges.size());
}

/// No ASCII character but a letter of some script, as far as blocks tell: no spaces, punctuation
/// or symbols.
bool is_foreign_letter(std::uint32_t code) {
  constexpr std::array others{
      CodeRange{0x80, 0xbf},     CodeRange{0xd7, 0xd7},     CodeRange{0xf7, 0xf7},
      CodeRange{0x1680, 0x1680}, CodeRange{0x2000, 0x2bff}, CodeRange{0x2e00, 0x2e7f},
      CodeRange{0x3000, 0x3004}, CodeRange{0x3008, 0x3020}, CodeRange{0xfe10, 0xfe6f},
      CodeRange{0xff00, 0xff0f}, CodeRange{0xff1a, 0xff20}, CodeRange{0xff3b, 0xff40},
      CodeRange{0xff5b, 0xff65}, CodeRange{0xffe0, 0xffee}, CodeRange{0x1f000, 0x1faff}};
  return code >= 0x80 && !is_hidden(code) &&
         !is_among(code, others.data(), others.data() + others.size());
}

bool is_file_character(std::uint32_t code) {
  const bool plain = (code >= 'a' && code <= 'z') || (code >= 'A' && code <= 'Z') ||
                     (code >= '0' && code <= '9') || code == ' ' || code == '_' || code == '-' ||
                     code == '.';
  return plain || is_foreign_letter(code);
}

/// @param mark goes before each of `special`
std::string out_of_bounds(std::string_view text, std::string_view special, char mark) {
  std::string result;
  for (const char c : text) {
    if (special.find(c) != std::string_view::npos) result += mark;
    result += c;
  }
  return result;
}

}  // namespace

std::string one_line(std::string_view text) {
  std::string result;
  while (!text.empty()) {
    const Character c = first_of(text);
    text.remove_prefix(c.bytes.size());
    if (c.valid && !is_hidden(c.code))
      result += c.bytes;
    else
      result += '?';
  }
  return result;
}

std::string quoted_start(std::string_view text, std::size_t most) {
  std::string result(text.substr(0, most));
  std::replace_if(
      result.begin(), result.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return "\"" + result + "\"";
}

bool is_control(char c) {
  return static_cast<unsigned char>(c) < ' ' || c == '\x7f';
}

std::string without_controls(std::string text) {
  std::replace_if(text.begin(), text.end(), is_control, '?');
  return text;
}

std::string safe_file_name(std::string_view text) {
  std::string result;
  while (!text.empty()) {
    const Character c = first_of(text);
    text.remove_prefix(c.bytes.size());
    const std::string_view kept = c.valid && is_file_character(c.code) ? c.bytes : "_";
    if (result.size() + kept.size() > max_file_name) break;
    result += kept;
  }
  if (result.empty()) return "_";
  // A dot would hide the file, a dash would make it an option of other programs.
  if (result[0] == '.' || result[0] == '-') result[0] = '_';
  return result;
}

std::string gnuplot_text(std::string_view text) {
  // A doubled quotation mark next to the first one would end the text.
  std::string result = "'";
  for (const char c : one_line(text)) result += c == '\'' ? "\u2019" : std::string(1, c);
  return result + "'";
}

std::string csv_text(std::string_view text) {
  std::string line = one_line(text);
  const std::size_t first = line.find_first_not_of(' ');
  if (first != std::string::npos &&
      std::string_view("=+-@").find(line[first]) != std::string_view::npos)
    line.insert(0, 1, '\'');
  return "\"" + out_of_bounds(line, "\"", '"') + "\"";
}

std::string script_json(std::string_view json) {
  // A '<' stands in texts alone.
  std::string result;
  for (const char c : json) {
    if (c == '<')
      result += "\\u003c";
    else
      result += c;
  }
  return result;
}

std::string obj_name(std::string_view text) {
  std::string line = one_line(text);
  std::replace(line.begin(), line.end(), '\\', '_');
  return line;
}

std::string usd_text(std::string_view text) {
  return "\"" + out_of_bounds(one_line(text), "\"\\", '\\') + "\"";
}

}  // namespace weft
