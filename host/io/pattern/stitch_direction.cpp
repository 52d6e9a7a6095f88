#include "host/io/pattern/stitch_direction.hpp"

#include <algorithm>
#include <cstddef>
#include <map>
#include <optional>
#include <utility>

#include "host/input/counted.hpp"
#include "weft/core/at.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

/// The file is overruled if the ends are this much nearer to each other the other way round, over
/// how near they are as it says.
constexpr double clearly_nearer = 0.7;
/// The same for the sum over all stitches of two panels.
constexpr double clearly_nearer_in_sum = 0.9;
/// As it says, seams are not sure to run the right way if the other way is nearer by more than
/// rounding and the sides of panels that stand askew.
constexpr double hardly_nearer_in_sum = 0.997;

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
  explicit PanelTurns(const SewingPattern& pattern) {
    for (std::size_t p = 0; p < pattern.panels.size(); ++p) {
      leader_.push_back(p);
      differs_.push_back(false);
    }
  }

  /// Sews a stitch, beginning to end or not.
  /// @return whether front would meet back
  bool join(const PatternStitch& stitch, bool opposite) {
    const auto [a, b] = leaders(stitch);
    if (a == b) return differ(stitch) == opposite;
    const bool differs = differ(stitch) == opposite;
    for (std::size_t p = 0; p < leader_.size(); ++p)
      if (leader_[p] == b) {
        leader_[p] = a;
        differs_[p] = differs_[p] != differs;
      }
    return false;
  }

  /// How a stitch has to be sewn, if stitches that are joined say so.
  std::optional<bool> opposite(const PatternStitch& stitch) const {
    const auto [a, b] = leaders(stitch);
    if (a != b) return std::nullopt;
    return !differ(stitch);
  }

  std::vector<bool> turned() const {
    std::vector<bool> turned;
    for (std::size_t p = 0; p < leader_.size(); ++p) {
      std::size_t all = 0, over = 0;
      for (std::size_t q = 0; q < leader_.size(); ++q) {
        if (leader_[q] != leader_[p]) continue;
        ++all;
        over += differs_[q] ? 1 : 0;
      }
      turned.push_back(differs_[p] != (2 * over > all));
    }
    return turned;
  }

 private:
  std::pair<std::size_t, std::size_t> leaders(const PatternStitch& stitch) const {
    return {leader_[at(stitch.sides[0].panel)], leader_[at(stitch.sides[1].panel)]};
  }
  /// Whether one of its panels is turned over and the other is not, as far as either's leader says.
  bool differ(const PatternStitch& stitch) const {
    return differs_[at(stitch.sides[0].panel)] != differs_[at(stitch.sides[1].panel)];
  }

  std::vector<std::size_t> leader_;  ///< [panels] the first of those that hang together
  std::vector<bool> differs_;        ///< [panels] turned over if the leader is not
};

/// What of a pattern's stitches is sewn beginning to end, and which panels that turns over.
struct Directions {
  std::vector<bool> opposite, turned;
};

/// @param sure  [stitches] what is certain
/// @param file  [stitches] what the rest follows, unless what is certain overrules the file
/// @param wrong gets the number of a stitch along which front would meet back
std::optional<Directions> consistent(const SewingPattern& pattern,
                                     const std::vector<std::optional<bool>>& sure,
                                     const std::vector<bool>& file, std::size_t& wrong) {
  PanelTurns turns(pattern);
  Directions found{file, {}};
  const auto sewn = [&](std::size_t k) {
    wrong = k;
    return !turns.join(pattern.stitches[k], found.opposite[k]);
  };
  bool overruled = false;
  for (std::size_t k = 0; k < sure.size(); ++k) {
    if (!sure[k]) continue;
    found.opposite[k] = *sure[k];
    overruled = overruled || *sure[k] != file[k];
    if (!sewn(k)) return std::nullopt;
  }
  for (std::size_t k = 0; k < sure.size(); ++k) {
    if (sure[k]) continue;
    if (overruled) found.opposite[k] = turns.opposite(pattern.stitches[k]).value_or(file[k]);
    if (!sewn(k)) return std::nullopt;
  }
  found.turned = turns.turned();
  return found;
}

std::string sides_text(const SewingPattern& pattern, const PatternStitch& stitch) {
  return field_of(pattern, stitch.sides[0]) + " and " + field_of(pattern, stitch.sides[1]);
}

/// The distances of all stitches of two panels, as the file says and the other way round.
class PairDistances {
 public:
  explicit PairDistances(const SewingPattern& pattern) {
    for (const PatternStitch& stitch : pattern.stitches) {
      auto& [as_given, otherwise] = sums_[key(stitch)];
      as_given += distance(pattern, stitch, !stitch.right_wrong);
      otherwise += distance(pattern, stitch, stitch.right_wrong);
    }
  }

  /// Which of two ways is clearly nearer: as the file says, or not.
  std::optional<bool> as_given(const PatternStitch& stitch) const {
    const auto& [as_given, otherwise] = sums_.at(key(stitch));
    if (otherwise < clearly_nearer_in_sum * as_given) return false;
    if (as_given < clearly_nearer_in_sum * otherwise) return true;
    return std::nullopt;
  }

 private:
  static std::pair<Index, Index> key(const PatternStitch& stitch) {
    return std::minmax(stitch.sides[0].panel, stitch.sides[1].panel);
  }
  std::map<std::pair<Index, Index>, std::pair<double, double>> sums_;  ///< [m]
};

/// Lines about pairs of panels whose stitches are sewn as the file says, though their ends are a
/// little nearer to each other the other way round.
std::vector<std::string> doubts(const SewingPattern& pattern, const std::vector<bool>& opposite) {
  struct Pair {
    double sewn = 0, otherwise = 0;  ///< [m]
    std::vector<std::size_t> as_given;
  };
  std::map<std::pair<Index, Index>, Pair> pairs;
  for (std::size_t k = 0; k < opposite.size(); ++k) {
    const PatternStitch& stitch = pattern.stitches[k];
    const auto [low, high] = std::minmax(stitch.sides[0].panel, stitch.sides[1].panel);
    if (low == high) continue;
    Pair& pair = pairs[{low, high}];
    pair.sewn += distance(pattern, stitch, opposite[k]);
    pair.otherwise += distance(pattern, stitch, !opposite[k]);
    if (opposite[k] != stitch.right_wrong) pair.as_given.push_back(k);
  }
  std::vector<std::string> lines;
  for (const auto& [panels, pair] : pairs) {
    if (pair.as_given.empty() || !(pair.otherwise < hardly_nearer_in_sum * pair.sewn)) continue;
    const std::size_t k = pair.as_given.front();
    const std::size_t others = pair.as_given.size() - 1;
    lines.push_back("pattern.stitches[" + std::to_string(k) + "]" +
                    (others > 0 ? " and " + counted(others, "more stitch") + " of these panels"
                                : std::string()) +
                    ": the direction is not sure along " +
                    sides_text(pattern, pattern.stitches[k]) +
                    ", sewn as the file says: the ends are nearer to each other the other way "
                    "round; do all outlines run counter-clockwise, seen from outside?");
  }
  return lines;
}

}  // namespace

StitchDirections choose_directions(const SewingPattern& pattern) {
  const PairDistances pairs(pattern);
  std::vector<bool> given;
  std::vector<std::optional<bool>> certain, nearer;
  for (const PatternStitch& stitch : pattern.stitches) {
    const bool file = !stitch.right_wrong;
    const std::optional<bool> shared = by_shared_vertex(pattern, stitch);
    const double as_given = distance(pattern, stitch, file);
    const double otherwise = distance(pattern, stitch, !file);
    std::optional<bool> seen = shared;
    if (!seen && otherwise < clearly_nearer * as_given) seen = !file;
    if (!seen && as_given < clearly_nearer * otherwise) seen = file;
    if (const std::optional<bool> both = pairs.as_given(stitch); !seen && both)
      seen = *both ? file : !file;
    given.push_back(shared.value_or(file));
    certain.emplace_back(shared.value_or(file));
    nearer.push_back(seen);
  }
  const auto distance_of = [&](const std::vector<bool>& opposite) {
    double sum = 0;
    for (std::size_t k = 0; k < opposite.size(); ++k)
      sum += distance(pattern, pattern.stitches[k], opposite[k]);
    return sum;
  };
  std::size_t wrong = 0;
  std::optional<Directions> found = consistent(pattern, nearer, given, wrong);
  if (!found || distance_of(found->opposite) > distance_of(given))
    if (std::optional<Directions> as_given = consistent(pattern, certain, given, wrong))
      found = std::move(as_given);
  if (!found)
    throw SceneError(
        pattern.file, "pattern.stitches[" + std::to_string(wrong) + "]",
        "front sewn to back along " + sides_text(pattern, pattern.stitches[wrong]),
        "stitches that leave all panels with their fronts on one side, however they are turned");
  StitchDirections result;
  result.opposite = std::move(found->opposite);
  result.turned = std::move(found->turned);
  for (std::size_t k = 0; k < pattern.stitches.size(); ++k)
    if (result.opposite[k] == pattern.stitches[k].right_wrong)
      result.notes.push_back(
          "pattern.stitches[" + std::to_string(k) +
          "]: " + sides_text(pattern, pattern.stitches[k]) + " are sewn " +
          (result.opposite[k] ? "beginning to end" : "beginning to beginning") +
          ", other than the file says, since the ends of seams are nearer to each other that way");
  for (std::string& line : doubts(pattern, result.opposite))
    result.notes.push_back(std::move(line));
  return result;
}

}  // namespace weft::io
