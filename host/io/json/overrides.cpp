#include "host/io/json/overrides.hpp"

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "host/io/json/json_fields.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

using nlohmann::json;

std::optional<std::size_t> as_place(const std::string& token) {
  std::size_t place = 0;
  const char* end = token.data() + token.size();
  const auto [stop, error] = std::from_chars(token.data(), end, place);
  if (error != std::errc() || stop != end) return {};
  return place;
}

std::vector<std::string> split(const std::string& path) {
  std::vector<std::string> tokens(1);
  for (const char c : path) {
    if (c == '.')
      tokens.emplace_back();
    else
      tokens.back() += c;
  }
  return tokens;
}

/// `method=adaptive` is short for `method.type=adaptive` and leaves the rest of `method` alone.
json& place_of_method_type(json& scene) {
  json& method = scene["method"];
  if (!method.is_object()) method = json::object();
  return method["type"];
}

}  // namespace

json override_value(const std::string& text, const std::string& file, const std::string& path) {
  try {
    return parse_json(text, file);
  } catch (const SceneError&) {
    // No JSON: words need no quotes on a command line.
  }
  json value = text;
  try {
    (void)value.dump();
  } catch (const json::type_error&) {
    throw SceneError(file, path, short_text(value), "text in UTF-8");
  }
  return value;
}

void apply_override(json& scene, const std::string& override_text, const std::string& file) {
  const std::size_t equals = override_text.find('=');
  const std::string path = override_text.substr(0, equals);
  const std::vector<std::string> tokens = split(path);
  if (equals == std::string::npos ||
      std::any_of(tokens.begin(), tokens.end(), [](const auto& t) { return t.empty(); }))
    throw SceneError(file, "--set", short_text(json(override_text)),
                     "path=value, such as time.step=0.002");

  json* place = &scene;
  std::string walked;
  for (const std::string& token : tokens) {
    const std::string here = walked.empty() ? "scene" : walked;
    walked += (walked.empty() ? "" : ".") + token;
    if (place->is_null()) *place = json::object();
    if (place->is_array()) {
      const auto index = as_place(token);
      if (!index || *index >= place->size())
        throw SceneError(file, "--set " + walked, short_text(json(token)),
                         place->empty()       ? "nothing, " + here + " is empty"
                         : place->size() == 1 ? "0, the only place in " + here
                                              : "0 to " + std::to_string(place->size() - 1) +
                                                    ", the places in " + here);
      place = &(*place)[*index];
    } else if (place->is_object()) {
      place = &(*place)[token];
    } else {
      throw SceneError(file, "--set " + walked, "unknown path",
                       here + " itself, which is " + short_text(*place));
    }
  }
  json value = override_value(override_text.substr(equals + 1), file, path);
  if (path == "method" && value.is_string()) place = &place_of_method_type(scene);
  *place = std::move(value);
}

}  // namespace weft::io
