#include "host/io/json/json_fields.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "host/input/nearest_word.hpp"
#include "host/input/safe_text.hpp"
#include "host/io/json/experimental_paths.hpp"
#include "host/io/json/json_document.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

using nlohmann::json;

constexpr std::size_t max_shown = 80;
constexpr std::ptrdiff_t max_words = 40;
constexpr std::size_t max_reason = 400;

const json empty_object = json::object();

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

std::string quoted(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "\"" : ", \"") + word + "\"";
  return text;
}

std::string position_of(std::string_view text, std::size_t offset) {
  const std::string_view before = text.substr(0, std::min(offset, text.size()));
  const auto lines = std::count(before.begin(), before.end(), '\n');
  const std::size_t start = before.rfind('\n') + 1;  // npos + 1 is 0
  return "line " + std::to_string(lines + 1) + ", column " +
         std::to_string(before.size() - start + 1);
}

/// What nlohmann-json says after its own tags. It repeats what it read last, of any length.
std::string reason_of(const std::string& what, const std::string& after) {
  const std::size_t found = what.find(after);
  const std::size_t begin = found == std::string::npos ? 0 : found + after.size();
  const std::string reason = without_controls(what.substr(begin, max_reason));
  return what.size() - begin > max_reason ? reason + "..." : reason;
}

/// Words that may stand somewhere. There may be none, such as names of materials.
std::string allowed_words(const std::vector<std::string>& words) {
  if (words.empty()) return "a name that the scene defines, and it defines none";
  if (std::ssize(words) <= max_words) return quoted(words);
  return quoted({words.begin(), words.begin() + max_words}) + ", ... (" +
         std::to_string(words.size()) + " in all)";
}

std::string type_text(std::size_t count) {
  return "a list of " + std::to_string(count) + " numbers";
}

std::optional<std::int64_t> as_integer(const json& value) {
  if (value.is_number_unsigned()) {
    const auto wide = value.get<std::uint64_t>();
    if (wide > static_cast<std::uint64_t>(INT64_MAX)) return {};
    return static_cast<std::int64_t>(wide);
  }
  if (value.is_number_integer()) return value.get<std::int64_t>();
  if (value.is_number_float()) {
    const double real = value.get<double>();
    if (std::abs(real) < 9e15 && real == std::floor(real)) return static_cast<std::int64_t>(real);
  }
  return {};
}

}  // namespace

json parse_json(std::string_view text, const std::string& file) {
  // The parser takes a zero byte for the end of the file.
  if (const std::size_t zero = text.find('\0'); zero != std::string_view::npos)
    throw SceneError(file + ": bad JSON at " + position_of(text, zero) + ": a zero byte");
  JsonDocument document(file);
  try {
    json::sax_parse(text.begin(), text.end(), &document, json::input_format_t::json, true, true);
    return document.take();
  } catch (const json::parse_error& error) {
    throw SceneError(file + ": bad JSON at " + reason_of(error.what(), "parse error at "));
  } catch (const json::out_of_range& error) {
    // Numbers too large for a double come without a position; the token itself is in the text.
    const std::string what = error.what();
    const std::size_t open = what.find('\'');
    const std::size_t close = what.rfind('\'');
    std::string where;
    if (open != std::string::npos && close > open)
      where = position_of(text, text.find(what.substr(open + 1, close - open - 1))) + ": ";
    throw SceneError(file + ": bad JSON at " + where + reason_of(what, "] "));
  }
}

std::string short_text(const json& value) {
  std::string text = value.dump(-1, ' ', true, json::error_handler_t::replace);
  if (text.size() > max_shown) text = text.substr(0, max_shown) + "...";
  return text;
}

/// A path without places in lists: seams[3].cloth -> seams.cloth
std::string without_places(std::string path) {
  for (std::size_t open = path.find('['); open != std::string::npos; open = path.find('['))
    path.erase(open, path.find(']', open) - open + 1);
  return path;
}

/// The new name of a key that had another in version 0.1. One version long.
std::optional<std::string> renamed_key(const std::string& path) {
  static const std::map<std::string, std::string> renamed{
      {"contact.halvings", "substep_bisections"},
      {"contact.yielding_distance", "compliance_distance"},
      {"method.time_parallel.seam_tolerance", "boundary_tolerance"},
      {"obstacles.capture.first_frame", "first"},
      {"obstacles.capture.last_frame", "last"}};
  const auto found = renamed.find(without_places(path));
  return found == renamed.end() ? std::nullopt : std::optional(found->second);
}

/// A path without the name of a material: materials.silk.density -> materials.density
std::string without_material(std::string path) {
  constexpr std::string_view list = "materials.";
  if (path.starts_with(list)) path.erase(list.size(), path.rfind('.') + 1 - list.size());
  return path;
}

/// What to do about a key of version 0.1 that is gone. One version long.
std::optional<std::string> removed_key(const std::string& path) {
  static const std::map<std::string, std::string> removed{
      {"cloths.velocity_origin",
       "angular_velocity is about (0, 0, 0); subtract its cross product with this from velocity"},
      {"cloths.remeshing", "remeshing of the scene, for all cloths"},
      {"contact.stiffness", "remove it; contacts choose their stiffness themselves"},
      {"materials.thickness", "stretch_stiffness and bending_stiffness"},
      {"materials.young_modulus",
       "stretch_stiffness, which is young_modulus * thickness, and bending_stiffness, which is "
       "young_modulus * thickness^3 / (12 (1 - poisson_ratio^2))"},
      {"method.asynchronous.tune_window", "remove it; windows changed no result"},
      {"method.time_parallel.clock", "remove it; slices are cut by counted work"},
      {"method.time_parallel.track", "remove it; only recovery follows the coarse run"},
      {"obstacles.capture.edge", "remove it; edges are as long as the cloths' cells"},
      {"obstacles.capture.scale", "units of the obstacle, or height"},
      {"obstacles.capture.up", "up of the obstacle"},
      {"obstacles.compliance", "contact.compliance_distance, for all obstacles"},
      {"obstacles.driven.origin",
       "transform.translate of the obstacle, which the axis goes through"},
      {"obstacles.sequence.up", "up of the obstacle"},
      {"obstacles.skinned.scale", "units of the obstacle"},
      {"obstacles.skinned.up", "up of the obstacle"},
      {"seams.cloth", "cloths, with this name twice"}};
  const auto found = removed.find(without_material(without_places(path)));
  return found == removed.end() ? std::nullopt : std::optional(found->second);
}

Fields::Fields(const json& in, json& out, const std::string& file, std::string path,
               std::vector<std::string> keys)
    : in_(&in), out_(&out), file_(&file), path_(std::move(path)) {
  if (!in.is_object())
    throw SceneError(file, path_.empty() ? "scene" : path_, short_text(in), "an object {...}");
  out = json::object();
  if (keys.empty()) return;
  for (const auto& [key, value] : in.items()) {
    if (std::find(keys.begin(), keys.end(), key) != keys.end()) continue;
    const std::string full = path_.empty() ? key : path_ + "." + key;
    if (const auto advice = removed_key(full))
      throw SceneError(file + ": " + full + ": no longer a key: " + *advice);
    if (const auto now = renamed_key(full))
      throw SceneError(file, path_of(key), "a name of version 0.1",
                       "its new name, \"" + *now + "\"");
    const std::string shown = short_text(json(key));
    std::erase_if(keys, [this](const std::string& known) { return is_hidden(path_of(known)); });
    throw SceneError(file, path_of(shown.substr(1, shown.size() - 2)), "unknown key",
                     keys.empty() ? "no key: --experimental sets such values"
                                  : joined(keys) + did_you_mean(key, keys));
  }
}

std::vector<std::string> Fields::present_keys() const {
  std::vector<std::string> keys;
  for (const auto& [key, value] : in_->items()) keys.push_back(key);
  return keys;
}

std::string Fields::path_of(const std::string& key) const {
  return without_controls(path_.empty() ? key : path_ + "." + key);
}

void Fields::refuse(const std::string& key, const std::string& allowed) const {
  const json* value = find(key);
  refuse(key, value ? short_text(*value) : "missing", allowed);
}

void Fields::refuse(const std::string& key, const std::string& value,
                    const std::string& allowed) const {
  throw SceneError(*file_, path_of(key), value, allowed);
}

const json* Fields::find(const std::string& key) const {
  const auto found = in_->find(key);
  return found == in_->end() ? nullptr : &*found;
}

const json& Fields::require(const std::string& key, const std::string& allowed) const {
  const json* value = find(key);
  if (!value) refuse(key, "missing", allowed);
  return *value;
}

double Fields::number(const std::string& key, std::optional<double> fallback) {
  double result = 0;
  if (!has(key) && fallback) {
    result = *fallback;
  } else {
    const json& value = require(key, "a number");
    if (!value.is_number()) refuse(key, "a number");
    result = value.get<double>();
    if (!std::isfinite(result)) refuse(key, "a finite number");
  }
  record(key, result);
  return result;
}

std::optional<double> Fields::number_or_null(const std::string& key) {
  if (has(key) && !in_->at(key).is_null()) {
    if (!in_->at(key).is_number()) refuse(key, "a number or null");
    return number(key);
  }
  record(key, nullptr);
  return {};
}

double Fields::positive(const std::string& key, std::optional<double> fallback) {
  const double value = number(key, fallback);
  if (!(value > 0)) refuse(key, "a number > 0");
  return value;
}

double Fields::number(const std::string& key, const Quantity& kind,
                      std::optional<double> fallback) {
  const double value = number(key, fallback);
  if (!kind.holds(value)) refuse(key, short_text(value), kind.allowed());
  return value;
}

Vec3<double> Fields::direction(const std::string& key, const Vec3<double>& fallback) {
  const auto given = vector<3>(key, fallback);
  // Divided by the largest component first, so that no square overflows or vanishes.
  const double largest = std::max({std::abs(given[0]), std::abs(given[1]), std::abs(given[2])});
  if (!(largest > 0)) refuse(key, "a vector that is not zero");
  const Vec3<double> scaled{given[0] / largest, given[1] / largest, given[2] / largest};
  return scaled * (1.0 / length(scaled));
}

std::int64_t Fields::integer(const std::string& key, std::optional<std::int64_t> fallback,
                             std::int64_t low, std::int64_t high) {
  const std::string allowed =
      "an integer from " + std::to_string(low) + " to " + std::to_string(high);
  std::optional<std::int64_t> value = fallback;
  if (has(key) || !fallback) value = as_integer(require(key, allowed));
  if (!value || *value < low || *value > high) refuse(key, allowed);
  record(key, *value);
  return *value;
}

bool Fields::boolean(const std::string& key, bool fallback) {
  if (has(key)) {
    if (!in_->at(key).is_boolean()) refuse(key, "true or false");
    fallback = in_->at(key).get<bool>();
  }
  record(key, fallback);
  return fallback;
}

std::string Fields::text(const std::string& key, std::optional<std::string> fallback) {
  std::string result;
  if (!has(key) && fallback) {
    result = *fallback;
  } else {
    const json& value = require(key, "a text");
    if (!value.is_string()) refuse(key, "a text");
    result = value.get<std::string>();
  }
  record(key, result);
  return result;
}

std::string Fields::name(const std::string& key, const std::string& fallback) {
  const std::string result = text(key, fallback);
  const auto allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-';
  };
  if (result.empty() || !std::all_of(result.begin(), result.end(), allowed))
    refuse(key, "letters, digits, _ and -");
  return result;
}

std::size_t Fields::choice(const std::string& key, const std::vector<std::string>& words,
                           std::optional<std::size_t> fallback) {
  std::size_t result = 0;
  if (!has(key) && fallback) {
    result = *fallback;
  } else {
    const std::string allowed = allowed_words(words);
    const json& value = require(key, allowed);
    if (!value.is_string()) refuse(key, allowed);
    const auto& word = value.get_ref<const std::string&>();
    const auto found = std::find(words.begin(), words.end(), word);
    if (found == words.end()) refuse(key, allowed + did_you_mean(word, words));
    result = static_cast<std::size_t>(found - words.begin());
  }
  record(key, words[result]);
  return result;
}

std::vector<std::size_t> Fields::choices(const std::string& key,
                                         const std::vector<std::string>& words) {
  const std::string allowed = "a list of some of " + quoted(words);
  const json& value = require(key, allowed);
  if (!value.is_array()) refuse(key, allowed);
  std::vector<std::size_t> result;
  for (std::size_t k = 0; k < value.size(); ++k) {
    const auto found = value[k].is_string() ? std::find(words.begin(), words.end(),
                                                        value[k].get_ref<const std::string&>())
                                            : words.end();
    if (found == words.end())
      refuse(key + "[" + std::to_string(k) + "]", short_text(value[k]), quoted(words));
    result.push_back(static_cast<std::size_t>(found - words.begin()));
  }
  record(key, value);
  return result;
}

std::vector<std::int64_t> Fields::integers(const std::string& key, std::int64_t low,
                                           std::int64_t high, std::optional<std::size_t> count) {
  const std::string each = "an integer from " + std::to_string(low) + " to " + std::to_string(high);
  const std::string allowed =
      (count ? "a list of " + std::to_string(*count) : std::string("a list")) + ", each " + each;
  const json& value = require(key, allowed);
  if (!value.is_array() || (count && value.size() != *count)) refuse(key, allowed);
  std::vector<std::int64_t> result;
  result.reserve(value.size());
  for (std::size_t k = 0; k < value.size(); ++k) {
    const auto entry = as_integer(value[k]);
    if (!entry || *entry < low || *entry > high)
      refuse(key + "[" + std::to_string(k) + "]", short_text(value[k]), each);
    result.push_back(*entry);
  }
  record(key, result);
  return result;
}

std::vector<std::vector<std::int64_t>> Fields::integer_lists(const std::string& key,
                                                             std::int64_t low, std::int64_t high,
                                                             std::optional<std::size_t> count,
                                                             std::optional<std::size_t> each) {
  const std::string number =
      "an integer from " + std::to_string(low) + " to " + std::to_string(high);
  const std::string inner =
      (each ? "a list of " + std::to_string(*each) : std::string("a list")) + ", each " + number;
  const std::string allowed =
      (count ? "a list of " + std::to_string(*count) : std::string("a list")) + ", each " + inner;
  const json& value = require(key, allowed);
  if (!value.is_array() || (count && value.size() != *count)) refuse(key, allowed);
  std::vector<std::vector<std::int64_t>> result(value.size());
  for (std::size_t k = 0; k < value.size(); ++k) {
    const std::string entry = key + "[" + std::to_string(k) + "]";
    if (!value[k].is_array() || (each && value[k].size() != *each))
      refuse(entry, short_text(value[k]), inner);
    for (std::size_t i = 0; i < value[k].size(); ++i) {
      const auto whole = as_integer(value[k][i]);
      if (!whole || *whole < low || *whole > high)
        refuse(entry + "[" + std::to_string(i) + "]", short_text(value[k][i]), number);
      result[k].push_back(*whole);
    }
  }
  record(key, result);
  return result;
}

std::vector<std::vector<double>> Fields::number_lists(const std::string& key, std::size_t low,
                                                      std::size_t high) {
  const std::string count =
      low == high ? std::to_string(low) : std::to_string(low) + " to " + std::to_string(high);
  const std::string inner = "a list of " + count + " numbers";
  const json& value = require(key, "a list, each " + inner);
  if (!value.is_array()) refuse(key, "a list, each " + inner);
  std::vector<std::vector<double>> result(value.size());
  for (std::size_t k = 0; k < value.size(); ++k) {
    const std::string entry = key + "[" + std::to_string(k) + "]";
    if (!value[k].is_array() || value[k].size() < low || value[k].size() > high)
      refuse(entry, short_text(value[k]), inner);
    for (std::size_t i = 0; i < value[k].size(); ++i) {
      if (!value[k][i].is_number())
        refuse(entry + "[" + std::to_string(i) + "]", short_text(value[k][i]), "a number");
      result[k].push_back(value[k][i].get<double>());
    }
  }
  record(key, result);
  return result;
}

std::vector<std::string> Fields::texts(const std::string& key, std::size_t count) {
  const std::string allowed = "a list of " + std::to_string(count) + " texts";
  const json& value = require(key, allowed);
  const auto is_text = [](const json& entry) { return entry.is_string(); };
  if (!value.is_array() || value.size() != count ||
      !std::all_of(value.begin(), value.end(), is_text))
    refuse(key, allowed);
  record(key, value);
  return value.get<std::vector<std::string>>();
}

std::vector<double> Fields::numbers(const std::string& key, std::size_t count,
                                    std::optional<std::vector<double>> fallback) {
  std::vector<double> result;
  if (!has(key) && fallback) {
    result = *fallback;
  } else {
    const json& value = require(key, type_text(count));
    if (!value.is_array() || value.size() != count) refuse(key, type_text(count));
    for (std::size_t k = 0; k < count; ++k) {
      if (!value[k].is_number())
        refuse(key + "[" + std::to_string(k) + "]", short_text(value[k]), "a number");
      result.push_back(value[k].get<double>());
    }
  }
  record(key, result);
  return result;
}

Fields Fields::object(const std::string& key, std::vector<std::string> keys) {
  const json* value = find(key);
  return {value ? *value : empty_object, (*out_)[key], *file_, path_of(key), std::move(keys)};
}

std::vector<Fields> Fields::objects(const std::string& key, const std::vector<std::string>& keys) {
  std::vector<Fields> result;
  json& out = (*out_)[key];
  out = json::array();
  const json* value = find(key);
  if (!value) return result;
  if (!value->is_array()) refuse(key, "a list [...] of objects");
  // Sized at once: the entries keep references into it.
  out = json(value->size(), json());
  for (std::size_t k = 0; k < value->size(); ++k)
    result.emplace_back((*value)[k], out[k], *file_, path_of(key) + "[" + std::to_string(k) + "]",
                        keys);
  return result;
}

std::string Fields::one_of(const std::vector<std::string>& keys) const {
  std::vector<std::string> present;
  for (const std::string& key : keys)
    if (has(key)) present.push_back(key);
  if (present.size() != 1)
    throw SceneError(
        *file_, path_.empty() ? "scene" : path_,
        present.empty() ? "none of " + joined(keys) : "more than one of them, " + joined(present),
        "one of " + joined(keys));
  return present.front();
}

}  // namespace weft::io
