#include "host/lab/worn/body_figure.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <queue>

#include "weft/core/at.hpp"

namespace weft::lab {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr std::size_t slices = 24;   // of a part, for its centre line
constexpr std::size_t samples = 12;  // that mean distances are measured from

/// Mean distance at a tip over the smallest one of the surface.
constexpr double prominence = 1.15;

using Neighbours = std::vector<std::vector<Index>>;

/// Neighbours along edges, and across each edge of two triangles: with these, distances along
/// edges are within a few per cent of those on the surface.
Neighbours neighbours_of(const Mesh& body) {
  Neighbours neighbours(body.positions.size());
  std::vector<std::array<Index, 3>> sides;  // of an edge: its ends, the corner across
  for (const Tri& t : body.triangles)
    for (int k = 0; k < 3; ++k) {
      const Index a = t.v[k], b = t.v[(k + 1) % 3], c = t.v[(k + 2) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), c});
    }
  std::sort(sides.begin(), sides.end());
  const auto join = [&](Index a, Index b) {
    neighbours[at(a)].push_back(b);
    neighbours[at(b)].push_back(a);
  };
  for (std::size_t s = 0; s < sides.size(); ++s) {
    const bool same = s > 0 && sides[s][0] == sides[s - 1][0] && sides[s][1] == sides[s - 1][1];
    if (!same) join(sides[s][0], sides[s][1]);
    if (same && sides[s][2] != sides[s - 1][2]) join(sides[s][2], sides[s - 1][2]);
  }
  return neighbours;
}

/// Distances along the surface from a set of vertices, within the vertices that `within` accepts.
std::vector<double> distances(const Neighbours& neighbours, const std::vector<Vec3<double>>& x,
                              const std::vector<Index>& from,
                              const std::function<bool(Index)>& within) {
  std::vector<double> distance(x.size(), infinity);
  using Entry = std::pair<double, Index>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  for (const Index v : from) {
    distance[at(v)] = 0;
    queue.push({0, v});
  }
  while (!queue.empty()) {
    const auto [d, v] = queue.top();
    queue.pop();
    if (d > distance[at(v)]) continue;
    for (const Index w : neighbours[at(v)]) {
      const double next = d + length(x[at(w)] - x[at(v)]);
      if (!(next < distance[at(w)]) || !within(w)) continue;
      distance[at(w)] = next;
      queue.push({next, w});
    }
  }
  return distance;
}

bool everywhere(Index) {
  return true;
}

/// Where a function that may be infinite is largest.
Index largest(const std::vector<double>& values) {
  Index best = -1;
  for (std::size_t v = 0; v < values.size(); ++v)
    if (std::isfinite(values[v]) && (best < 0 || values[v] > values[at(best)]))
      best = static_cast<Index>(v);
  return best;
}

Index largest_component_vertex(const Neighbours& neighbours) {
  std::vector<char> seen(neighbours.size(), 0);
  std::size_t most = 0;
  Index best = 0;
  for (std::size_t v = 0; v < neighbours.size(); ++v) {
    if (seen[v] != 0) continue;
    std::vector<Index> stack{static_cast<Index>(v)};
    seen[v] = 1;
    std::size_t count = 0;
    while (!stack.empty()) {
      const Index w = stack.back();
      stack.pop_back();
      ++count;
      for (const Index n : neighbours[at(w)])
        if (seen[at(n)] == 0) {
          seen[at(n)] = 1;
          stack.push_back(n);
        }
    }
    if (count > most) {
      most = count;
      best = static_cast<Index>(v);
    }
  }
  return best;
}

/// Vertices of the component of {distance > level} that holds `tip`, for the smallest level at
/// which it holds none of the `others`: the limb up to where it joins the rest.
std::vector<Index> limb_of(const Neighbours& neighbours, const std::vector<double>& distance,
                           Index tip, const std::vector<Index>& others) {
  std::vector<Index> order(distance.size());
  std::iota(order.begin(), order.end(), 0);
  std::erase_if(order, [&](Index v) { return !std::isfinite(distance[at(v)]); });
  std::sort(order.begin(), order.end(), [&](Index a, Index b) {
    return std::pair(-distance[at(a)], a) < std::pair(-distance[at(b)], b);
  });
  std::vector<Index> root(distance.size(), -1);
  const auto find = [&](Index v) {
    while (root[at(v)] != v) v = root[at(v)] = root[at(root[at(v)])];
    return v;
  };
  std::size_t added = 0;
  double level = 0;
  for (; added < order.size(); ++added) {
    const Index v = order[added];
    root[at(v)] = v;
    for (const Index w : neighbours[at(v)])
      if (root[at(w)] >= 0) root[at(find(w))] = find(v);
    const bool joined =
        root[at(tip)] >= 0 && std::any_of(others.begin(), others.end(), [&](Index o) {
          return root[at(o)] >= 0 && find(o) == find(tip);
        });
    if (!joined) continue;
    level = distance[at(v)];
    break;
  }
  std::vector<Index> limb{tip};
  std::vector<char> seen(distance.size(), 0);
  seen[at(tip)] = 1;
  for (std::size_t k = 0; k < limb.size(); ++k)
    for (const Index w : neighbours[at(limb[k])])
      if (seen[at(w)] == 0 && distance[at(w)] > level && std::isfinite(distance[at(w)])) {
        seen[at(w)] = 1;
        limb.push_back(w);
      }
  return limb;
}

/// Of an arm's length, from where its line is good to the joint of the shoulder.
constexpr double joint_reach = 0.22;

/// In strides: single slices wobble.
double line_length(const std::vector<Vec3<double>>& line) {
  constexpr std::size_t stride = 6;
  double sum = 0;
  for (std::size_t k = 0; k + 1 < line.size(); k += stride)
    sum += length(line[std::min(k + stride, line.size() - 1)] - line[k]);
  return sum;
}

/// Slices of the trunk between the arms are cut askew, to the front and to the back in turn: what
/// is beside a line with such kinks goes along it in jumps.
constexpr int trunk_passes = 6;

/// Moves inner points towards the middle of their neighbours.
void smooth(std::vector<Vec3<double>>& line) {
  const std::vector<Vec3<double>> before = line;
  for (std::size_t k = 1; k + 1 < line.size(); ++k)
    line[k] = before[k] * 0.5 + (before[k - 1] + before[k + 1]) * 0.25;
}

/// Slices where an arm begins are cut askew, and begin below the shoulder. The line goes straight
/// on there, up to the joint.
/// @param reach [m] from the first whole slice to the joint
void straighten_root(std::vector<Vec3<double>>& line, double reach) {
  constexpr std::size_t askew = 2, whole = 5;
  const Vec3<double> direction = line[askew] - line[askew + whole];
  line.erase(line.begin(), line.begin() + askew);
  line.insert(line.begin(), line[0] + direction * (reach / length(direction)));
}

/// Direction of a line at one of its points. Zero: the line has no length there
Vec3<double> tangent_at(const std::vector<Vec3<double>>& line, std::size_t k) {
  const Vec3<double> d = line[std::min(k + 1, line.size() - 1)] - line[k > 0 ? k - 1 : 0];
  return length(d) > 0 ? d * (1 / length(d)) : Vec3<double>{0, 0, 0};
}

/// @return unit, across `tangent`, and as close to `guess` as can be
Vec3<double> across(const Vec3<double>& tangent, const Vec3<double>& guess) {
  const Vec3<double> a = guess - tangent * dot(guess, tangent);
  if (length(a) > 1e-6) return a * (1 / length(a));
  // They are parallel: any direction across will do, as it turns with the surface.
  const Vec3<double> other =
      std::abs(tangent[0]) < 0.6 ? Vec3<double>{1, 0, 0} : Vec3<double>{0, 1, 0};
  const Vec3<double> b = cross(tangent, other);
  return length(b) > 0 ? b * (1 / length(b)) : other;
}

bool says(const std::string& text, std::initializer_list<const char*> words) {
  return std::any_of(words.begin(), words.end(),
                     [&](const char* word) { return text.find(word) != std::string::npos; });
}

std::string lower(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

}  // namespace

BodyFigure::BodyFigure(const Mesh& body, const Vec3<double>& up,
                       const BodySegmentation& segmentation)
    : positions_(body.positions),
      neighbours_(neighbours_of(body)),
      part_(body.positions.size(), BodyPart::trunk),
      along_(body.positions.size(), infinity),
      names_{"the trunk", "an arm", "the other arm", "a leg", "the other leg"} {
  if (segmentation.empty())
    find_limbs();
  else
    take(segmentation);
  measure(up);
  if (has_limbs_) name_sides();
}

void BodyFigure::find_limbs() {
  // Mean distance to points that are spread over the surface: largest at tips.
  std::vector<double> mean(positions_.size(), 0), nearest(positions_.size(), infinity);
  Index from = largest_component_vertex(neighbours_);
  double widest = 0;
  for (std::size_t s = 0; s < samples; ++s) {
    const auto d = distances(neighbours_, positions_, {from}, everywhere);
    for (std::size_t v = 0; v < d.size(); ++v) {
      mean[v] += d[v] / samples;
      nearest[v] = std::min(nearest[v], d[v]);
      if (std::isfinite(d[v])) widest = std::max(widest, d[v]);
    }
    from = largest(nearest);
    if (from < 0) return;
  }
  std::vector<Index> tips;
  std::vector<std::vector<double>> from_tip;
  std::vector<double> left = mean;
  while (tips.size() < 5) {
    const Index tip = largest(left);
    if (tip < 0) break;
    const auto d = distances(neighbours_, positions_, {tip}, everywhere);
    bool local = true;
    for (std::size_t v = 0; v < d.size(); ++v) {
      if (d[v] < 0.05 * widest && mean[v] > mean[at(tip)]) local = false;
      if (d[v] < (local ? 0.2 : 0.02) * widest) left[v] = infinity;
    }
    if (!local) continue;
    tips.push_back(tip);
    from_tip.push_back(d);
  }
  if (tips.size() != 5) return;
  double least = infinity;
  for (std::size_t v = 0; v < mean.size(); ++v)
    if (mean[v] > 0) least = std::min(least, mean[v]);
  if (!(mean[at(tips.back())] > prominence * least)) return;  // a ball has tips everywhere
  // The crown is nearest to the other tips, the hands are nearest to it.
  const auto sum = [&](std::size_t t) {
    double all = 0;
    for (const Index other : tips) all += from_tip[t][at(other)];
    return all;
  };
  std::size_t crown = 0;
  for (std::size_t t = 1; t < 5; ++t)
    if (sum(t) < sum(crown)) crown = t;
  std::vector<std::size_t> limbs;
  for (std::size_t t = 0; t < 5; ++t)
    if (t != crown) limbs.push_back(t);
  std::sort(limbs.begin(), limbs.end(), [&](std::size_t a, std::size_t b) {
    return from_tip[crown][at(tips[a])] < from_tip[crown][at(tips[b])];
  });
  crown_ = tips[crown];
  for (std::size_t k = 0; k < 4; ++k) {
    std::vector<Index> others;
    for (const Index tip : tips)
      if (tip != tips[limbs[k]]) others.push_back(tip);
    for (const Index v : limb_of(neighbours_, from_tip[crown], tips[limbs[k]], others))
      part_[at(v)] = static_cast<BodyPart>(k + 1);
  }
  has_limbs_ = has_all_parts();
}

bool BodyFigure::has_all_parts() const {
  std::array<std::size_t, body_part_count> count{};
  for (const BodyPart part : part_) ++count[static_cast<std::size_t>(part)];
  return std::none_of(count.begin(), count.end(), [](std::size_t n) { return n < 10; });
}

void BodyFigure::take(const BodySegmentation& segmentation) {
  for (const auto& [given, vertices] : segmentation) {
    const std::string name = lower(given);
    const bool arm = says(name, {"arm", "hand", "elbow", "wrist"});
    const bool leg = says(name, {"leg", "foot", "feet", "knee", "toe", "thigh", "calf"});
    if (!arm && !leg) continue;
    const bool right = says(name, {"right"}) || name.ends_with("_r") || name.starts_with("r_");
    const BodyPart part = arm ? (right ? BodyPart::second_arm : BodyPart::first_arm)
                              : (right ? BodyPart::second_leg : BodyPart::first_leg);
    for (const Index v : vertices) part_[at(v)] = part;
  }
  has_limbs_ = has_all_parts();
}

void BodyFigure::measure(const Vec3<double>& up) {
  const auto in = [&](BodyPart part) {
    return [this, part](Index v) { return part_[at(v)] == part; };
  };
  if (!has_limbs_) std::fill(part_.begin(), part_.end(), BodyPart::trunk);
  for (std::size_t p = 1; has_limbs_ && p < body_part_count; ++p) {
    const auto part = static_cast<BodyPart>(p);
    std::vector<Index> root;
    for (std::size_t v = 0; v < part_.size(); ++v)
      if (part_[v] == part && std::any_of(neighbours_[v].begin(), neighbours_[v].end(),
                                          [&](Index w) { return part_[at(w)] != part; }))
        root.push_back(static_cast<Index>(v));
    const auto d = distances(neighbours_, positions_, root, in(part));
    for (std::size_t v = 0; v < d.size(); ++v)
      if (part_[v] == part) along_[v] = d[v];
  }
  if (crown_ < 0) {
    // The end of the trunk that is farther from the legs, or the upper one.
    std::vector<Index> legs;
    for (std::size_t v = 0; v < part_.size(); ++v)
      if (part_[v] == BodyPart::first_leg || part_[v] == BodyPart::second_leg)
        legs.push_back(static_cast<Index>(v));
    const auto d = distances(neighbours_, positions_, legs, everywhere);
    const auto value = [&](std::size_t v) {
      return has_limbs_ ? (std::isfinite(d[v]) ? d[v] : -infinity) : dot(positions_[v], up);
    };
    for (std::size_t v = 0; v < part_.size(); ++v)
      if (part_[v] == BodyPart::trunk && !neighbours_[v].empty() &&
          (crown_ < 0 || value(v) > value(at(crown_))))
        crown_ = static_cast<Index>(v);
  }
  if (crown_ < 0) return;
  const auto d = distances(neighbours_, positions_, {crown_}, in(BodyPart::trunk));
  for (std::size_t v = 0; v < d.size(); ++v)
    if (part_[v] == BodyPart::trunk) along_[v] = d[v];
  reach_.fill(0);
  for (std::size_t v = 0; v < part_.size(); ++v)
    if (std::isfinite(along_[v])) {
      double& reach = reach_[static_cast<std::size_t>(part_[v])];
      reach = std::max(reach, along_[v]);
    }
  const BodyLines pose = lines(positions_);
  if (has_limbs_ && std::any_of(pose.line.begin(), pose.line.end(),
                                [](const auto& line) { return line.size() < 3; })) {
    // Limbs that are no tubes, as in a damaged segmentation.
    has_limbs_ = false;
    crown_ = -1;
    return measure(up);
  }
  remember_places();
  height_ = line_length(pose.line[0]) + (line_length(pose.line[3]) + line_length(pose.line[4])) / 2;
}

BodyFigure::Slices BodyFigure::cut(const std::vector<Vec3<double>>& positions) const {
  Slices result;
  for (std::size_t p = 0; p < body_part_count; ++p) {
    if (!(reach_[p] > 0)) continue;
    std::vector<Vec3<double>> sum(slices, Vec3<double>{0, 0, 0});
    std::vector<double> count(slices, 0);
    const auto add = [&](double s, const Vec3<double>& x) {
      const auto k = std::min(slices - 1, static_cast<std::size_t>(s / reach_[p] * slices));
      sum[k] += x;
      count[k] += 1;
    };
    for (std::size_t v = 0; v < part_.size(); ++v) {
      if (static_cast<std::size_t>(part_[v]) != p || !std::isfinite(along_[v])) continue;
      add(along_[v], positions[v]);
      for (const Index w : neighbours_[v])
        if (at(w) > v && part_[at(w)] == part_[v] && std::isfinite(along_[at(w)]))
          add((along_[v] + along_[at(w)]) / 2, (positions[v] + positions[at(w)]) * 0.5);
    }
    for (std::size_t k = 0; k < slices; ++k)
      if (count[k] > 0) {
        result.centre[p].push_back(sum[k] * (1 / count[k]));
        result.number[p].push_back(k);
      }
  }
  for (int pass = 0; pass < trunk_passes; ++pass) smooth(result.centre[0]);
  const auto& centre = result.centre;
  Vec3<double> front{0, 1, 0};
  if (has_limbs_ && centre[0].size() > 1 && !centre[3].empty() && !centre[4].empty()) {
    const Vec3<double> hips = centre[4][0] - centre[3][0];
    const Vec3<double> normal = cross(centre[0].front() - centre[0].back(), hips);
    if (length(normal) > 0) front = normal * (1 / length(normal));
  }
  for (std::size_t p = 0; p < body_part_count; ++p)
    for (std::size_t k = 0; k < centre[p].size(); ++k)
      result.across[p].push_back(
          across(tangent_at(centre[p], k), k == 0 ? front : result.across[p].back()));
  return result;
}

std::vector<int> BodyFigure::slice_of(const Slices& pose) const {
  std::vector<int> result(part_.size(), -1);
  for (std::size_t v = 0; v < part_.size(); ++v) {
    const auto p = static_cast<std::size_t>(part_[v]);
    if (!std::isfinite(along_[v]) || !(reach_[p] > 0)) continue;
    const auto k = std::min(slices - 1, static_cast<std::size_t>(along_[v] / reach_[p] * slices));
    const auto& number = pose.number[p];
    const auto found = std::lower_bound(number.begin(), number.end(), k);
    if (found != number.end() && *found == k) result[v] = static_cast<int>(found - number.begin());
  }
  return result;
}

Vec2<double> BodyFigure::place_in(const Slices& pose, std::size_t part, std::size_t k,
                                  const Vec3<double>& x) const {
  const Vec3<double> from = x - pose.centre[part][k], ahead = pose.across[part][k];
  return {dot(from, ahead), dot(from, cross(tangent_at(pose.centre[part], k), ahead))};
}

void BodyFigure::remember_places() {
  const Slices pose = cut(positions_);
  const std::vector<int> slice = slice_of(pose);
  place_.assign(part_.size(), {0, 0});
  for (std::size_t v = 0; v < part_.size(); ++v)
    if (slice[v] >= 0)
      place_[v] = place_in(pose, static_cast<std::size_t>(part_[v]),
                           static_cast<std::size_t>(slice[v]), positions_[v]);
}

/// Turns the directions across so that the surface around each slice is where it was in the first
/// pose, on average.
void BodyFigure::turn_with_surface(const std::vector<Vec3<double>>& positions, Slices& pose) const {
  const std::vector<int> slice = slice_of(pose);
  std::array<std::vector<Vec2<double>>, body_part_count> turn;
  for (std::size_t p = 0; p < body_part_count; ++p) turn[p].assign(pose.centre[p].size(), {0, 0});
  for (std::size_t v = 0; v < part_.size(); ++v) {
    if (slice[v] < 0) continue;
    const auto p = static_cast<std::size_t>(part_[v]);
    const auto k = static_cast<std::size_t>(slice[v]);
    const Vec2<double> before = place_[v], now = place_in(pose, p, k, positions[v]);
    turn[p][k] += {dot(before, now), before[0] * now[1] - before[1] * now[0]};
  }
  for (std::size_t p = 0; p < body_part_count; ++p)
    for (std::size_t k = 0; k < turn[p].size(); ++k) {
      const double size = length(turn[p][k]);
      if (!(size > 0)) continue;
      const Vec3<double> ahead = pose.across[p][k];
      const Vec3<double> side = cross(tangent_at(pose.centre[p], k), ahead);
      pose.across[p][k] = ahead * (turn[p][k][0] / size) + side * (turn[p][k][1] / size);
    }
}

BodyLines BodyFigure::lines(const std::vector<Vec3<double>>& positions) const {
  Slices pose = cut(positions);
  if (!place_.empty()) turn_with_surface(positions, pose);
  BodyLines result{pose.centre, pose.across};
  if (!has_limbs_) return result;
  for (const std::size_t p : {std::size_t{1}, std::size_t{2}}) {
    std::vector<Vec3<double>>& ahead = result.ahead[p];
    if (result.line[p].size() <= 8) continue;
    straighten_root(result.line[p], joint_reach * line_length(result.line[p]));
    ahead.erase(ahead.begin());
    ahead[0] = ahead[1];  // the slice of the other one was askew
  }
  // Limbs begin on the trunk, so that the lines are one tree. Both arms begin at one point: what
  // passes between two would be around neither.
  const std::vector<Vec3<double>>& trunk = result.line[0];
  if (trunk.empty()) return result;
  const auto root = [&](std::size_t p) {
    return result.line[p].empty() ? trunk.front() : result.line[p].front();
  };
  const Vec3<double> between_arms = (root(1) + root(2)) * 0.5;
  const Vec3<double> arms_at =
      *std::min_element(trunk.begin(), trunk.end(), [&](const auto& a, const auto& b) {
        return length(a - between_arms) < length(b - between_arms);
      });
  for (std::size_t p = 1; p < body_part_count; ++p) {
    std::vector<Vec3<double>>& line = result.line[p];
    if (line.empty()) continue;
    line.insert(line.begin(), p >= 3 ? trunk.back() : arms_at);
    result.ahead[p].insert(result.ahead[p].begin(), result.ahead[p].front());
  }
  return result;
}

void BodyFigure::name_sides() {
  const BodyLines pose = lines(positions_);
  for (const std::size_t p : {std::size_t{1}, std::size_t{3}}) {
    if (pose.line[p].empty() || pose.line[p + 1].empty()) continue;
    const Vec3<double> between = pose.line[p].back() - pose.line[p + 1].back();
    int axis = 0;
    for (int k = 1; k < 3; ++k)
      if (std::abs(between[k]) > std::abs(between[axis])) axis = k;
    for (const std::size_t q : {p, p + 1}) {
      const bool positive = (between[axis] > 0) == (q == p);
      names_[q] = std::string(p == 1 ? "the arm at " : "the leg at ") + (positive ? "+" : "-") +
                  "xyz"[axis];
    }
  }
}

}  // namespace weft::lab
