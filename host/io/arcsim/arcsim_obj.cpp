#include "host/io/arcsim/arcsim_obj.hpp"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "host/base/file_bytes.hpp"
#include "host/input/safe_text.hpp"
#include "host/io/mesh/mesh_formats.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

/// Keywords whose numbers matter only if one of them is not zero.
constexpr std::array<std::pair<std::string_view, std::string_view>, 7> state_keywords{
    {{"nv", "node velocities (nv)"},
     {"vv", "vertex velocities (vv)"},
     {"ea", "rest angles of edges (ea)"},
     {"ed", "damage of edges (ed)"},
     {"ts", "plastic strain (ts)"},
     {"fs", "plastic strain (fs)"},
     {"td", "damage of faces (td)"}}};

bool any_not_zero(std::string_view line) {
  double value = 0;
  for (std::string_view word = next_word(line); !word.empty(); word = next_word(line))
    if (!parse_number(word, value) || value != 0) return true;
  return false;
}

bool same_numbers(std::string_view a, std::string_view b) {
  for (int k = 0; k < 3; ++k) {
    double x = 0;
    double y = 0;
    if (!parse_number(next_word(a), x) || !parse_number(next_word(b), y) || x != y) return false;
  }
  return true;
}

}  // namespace

ArcsimExtras read_arcsim_extras(const std::filesystem::path& path) {
  const std::string bytes = read_file_bytes(path);
  std::string_view rest = bytes;
  ArcsimExtras extras;
  const auto ignore = [&](std::string_view what) {
    if (std::find(extras.ignored.begin(), extras.ignored.end(), what) == extras.ignored.end())
      extras.ignored.emplace_back(what);
  };
  std::string_view last_vertex;
  for (std::size_t number = 1; !rest.empty(); ++number) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    std::string_view line = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    const std::string_view keyword = next_word(line);
    if (keyword == "v") {
      extras.node_label.push_back(0);
      last_vertex = line;
    }
    if (keyword == "ny" && !same_numbers(line, last_vertex)) ignore("plastic embedding (ny)");
    if (keyword == "nl") {
      const std::string_view word = next_word(line);
      long long label = 0;
      if (extras.node_label.empty() || !parse_number(word, label))
        throw SceneError(path.string(), "line " + std::to_string(number) + ": nl",
                         quoted_start(word, 20), "a whole number, after a vertex");
      extras.node_label.back() = label;
    }
    for (const auto& [word, meaning] : state_keywords)
      if (keyword == word && any_not_zero(line)) ignore(meaning);
  }
  return extras;
}

std::vector<Index> vertices_with_label(const ArcsimExtras& extras, long long label) {
  std::vector<Index> vertices;
  for (std::size_t v = 0; v < extras.node_label.size(); ++v)
    if (extras.node_label[v] == label) vertices.push_back(static_cast<Index>(v));
  return vertices;
}

}  // namespace weft::io
