#include "host/io/pattern/stitch_direction.hpp"

#include <algorithm>
#include <cstddef>
#include <optional>

#include "weft/core/at.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

/// The file is overruled if the ends are this much nearer to each other the other way round, over
/// how near they are as it says.
constexpr double clearly_nearer = 0.7;

Vec3<double> corner(const SewingPattern& pattern, const PatternSide& side, bool end) {
  const PatternPanel& panel = pattern.panel(side);
  const PatternEdge& edge = pattern.edge(side);
  return placed(panel, panel.vertices[at(end ? edge.to : edge.from)]);
}

/// [m] Sum of the distances of the ends.
double distance(const SewingPattern& pattern, const PatternStitch& stitch, bool opposite) {
  const auto& [a, b] = stitch.sides;
  return length(corner(pattern, a, false) - corner(pattern, b, opposite)) +
         length(corner(pattern, a, true) - corner(pattern, b, !opposite));
}

/// What the vertex that both sides share says, as the tip of a dart.
std::optional<bool> by_shared_vertex(const SewingPattern& pattern, const PatternStitch& stitch) {
  if (stitch.sides[0].panel != stitch.sides[1].panel) return std::nullopt;
  const PatternEdge &a = pattern.edge(stitch.sides[0]), &b = pattern.edge(stitch.sides[1]);
  if (a.to == b.from || a.from == b.to) return true;
  if (a.from == b.from || a.to == b.to) return false;
  return std::nullopt;
}

/// Which panels to turn over. As few as possible of those that hang together.
class PanelTurns {
 public:
  explicit PanelTurns(const SewingPattern& pattern) : pattern_(pattern) {}

  /// @return the first stitch along which front would meet back
  std::optional<std::size_t> find(const std::vector<bool>& opposite) {
    state_.assign(pattern_.panels.size(), unknown);
    std::vector<std::vector<std::size_t>> stitches_of(pattern_.panels.size());
    for (std::size_t k = 0; k < pattern_.stitches.size(); ++k)
      for (const PatternSide& side : pattern_.stitches[k].sides)
        stitches_of[at(side.panel)].push_back(k);
    for (std::size_t p = 0; p < state_.size(); ++p) {
      if (state_[p] != unknown) continue;
      std::vector<std::size_t> component{p};
      state_[p] = as_given;
      for (std::size_t i = 0; i < component.size(); ++i)
        for (const std::size_t k : stitches_of[component[i]]) {
          const auto& sides = pattern_.stitches[k].sides;
          const bool first = at(sides[0].panel) == component[i];
          const auto other = at(sides[first ? 1 : 0].panel);
          const int wanted = opposite[k] ? state_[component[i]] : 1 - state_[component[i]];
          if (state_[other] == unknown) {
            state_[other] = wanted;
            component.push_back(other);
          } else if (state_[other] != wanted) {
            return k;
          }
        }
      const auto over = std::count_if(component.begin(), component.end(),
                                      [&](std::size_t q) { return state_[q] == over_; });
      if (2 * static_cast<std::size_t>(over) > component.size())
        for (const std::size_t q : component) state_[q] = 1 - state_[q];
    }
    return std::nullopt;
  }

  std::vector<bool> turned() const {
    std::vector<bool> turned;
    for (const int state : state_) turned.push_back(state == over_);
    return turned;
  }

 private:
  static constexpr int unknown = -1, as_given = 0, over_ = 1;

  const SewingPattern& pattern_;
  std::vector<int> state_;
};

std::string sides_text(const SewingPattern& pattern, const PatternStitch& stitch) {
  return field_of(pattern, stitch.sides[0]) + " and " + field_of(pattern, stitch.sides[1]);
}

}  // namespace

StitchDirections choose_directions(const SewingPattern& pattern) {
  StitchDirections result;
  std::vector<bool> given, nearer;
  for (const PatternStitch& stitch : pattern.stitches) {
    const bool file = !stitch.right_wrong;
    const std::optional<bool> shared = by_shared_vertex(pattern, stitch);
    const bool other =
        distance(pattern, stitch, !file) < clearly_nearer * distance(pattern, stitch, file);
    given.push_back(shared.value_or(file));
    nearer.push_back(shared.value_or(other ? !file : file));
  }
  PanelTurns turns(pattern);
  result.opposite = nearer;
  if (turns.find(nearer)) {
    result.opposite = given;
    if (const auto stitch = turns.find(given))
      throw SceneError(
          pattern.file, "pattern.stitches[" + std::to_string(*stitch) + "]",
          "front sewn to back along " + sides_text(pattern, pattern.stitches[*stitch]),
          "stitches that leave all panels with their fronts on one side, however they are turned");
  }
  result.turned = turns.turned();
  for (std::size_t k = 0; k < pattern.stitches.size(); ++k)
    if (result.opposite[k] == pattern.stitches[k].right_wrong)
      result.notes.push_back(
          "pattern.stitches[" + std::to_string(k) +
          "]: " + sides_text(pattern, pattern.stitches[k]) + " are sewn " +
          (result.opposite[k] ? "beginning to end" : "beginning to beginning") +
          ", other than the file says, since their ends are nearer to each other that way");
  return result;
}

}  // namespace weft::io
