#include "host/lab/worn/front_and_back.hpp"

#include <cstddef>
#include <initializer_list>
#include <set>
#include <vector>

namespace weft::lab {
namespace {

/// Points at the end of a leg's line that are within the foot.
constexpr std::size_t foot_points = 4;
/// Least horizontal share of a foot's length: a shin has less.
constexpr double least_level = 0.7;
/// Cosine of the largest angle between a foot and the direction in which the body looks.
constexpr double least_ahead = 0.7;

std::set<std::string> words_of(const std::string& name) {
  std::set<std::string> words;
  std::string word;
  for (char c : name + "_") {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    if (c >= 'a' && c <= 'z') {
      word += c;
      continue;
    }
    words.insert(word);
    word.clear();
  }
  return words;
}

}  // namespace

PanelSide panel_side(const std::string& name) {
  const std::set<std::string> words = words_of(name);
  const auto any = [&](std::initializer_list<const char*> known) {
    for (const char* word : known)
      if (words.contains(word)) return true;
    return false;
  };
  const bool front = any({"front", "f", "ftorso"}), back = any({"back", "rear", "b", "btorso"});
  if (front == back) return PanelSide::unknown;
  return front ? PanelSide::front : PanelSide::back;
}

std::optional<Vec3<double>> looking(const BodyLines& body, const Vec3<double>& up) {
  std::vector<Vec3<double>> feet;
  for (const BodyPart leg : {BodyPart::first_leg, BodyPart::second_leg}) {
    const std::vector<Vec3<double>>& line = body.line[static_cast<std::size_t>(leg)];
    if (line.size() < 2 * foot_points) return std::nullopt;
    const Vec3<double> foot = line.back() - line[line.size() - foot_points];
    const Vec3<double> level = foot - up * dot(foot, up);
    if (!(length(level) > least_level * length(foot))) return std::nullopt;
    feet.push_back(level * (1 / length(level)));
  }
  const Vec3<double> both = feet[0] + feet[1];
  if (!(length(both) > 0)) return std::nullopt;
  const Vec3<double> ahead = both * (1 / length(both));
  if (dot(feet[0], ahead) > least_ahead) return ahead;
  return std::nullopt;
}

}  // namespace weft::lab
