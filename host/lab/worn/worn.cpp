#include "host/lab/worn/worn.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>

#include "host/lab/worn/front_and_back.hpp"
#include "host/lab/worn/loops.hpp"
#include "weft/core/at.hpp"

namespace weft::lab {
namespace {

constexpr int sectors = 12;             // about a line, for what is covered
constexpr double cell_rows = 0.03;      // of the height, down the trunk, for that too
constexpr double small_opening = 0.12;  // of the height: shorter ones may be pockets or buttonholes
constexpr double small_panel = 0.02;    // of the garment's area
constexpr double loose_opening = 1.5;   // over the length of the shortest one about the same part

constexpr double clearly_behind = 0.03;  // of the height: fronts from backs

using Points = std::vector<Vec3<double>>;

constexpr std::array<BodyPart, body_part_count> all_parts{BodyPart::trunk, BodyPart::first_arm,
                                                          BodyPart::second_arm, BodyPart::first_leg,
                                                          BodyPart::second_leg};

constexpr std::size_t index_of(BodyPart part) {
  return static_cast<std::size_t>(part);
}

/// What a label says of a panel.
enum class Kind { unknown, arm, leg };

Kind kind_of(std::string name) {
  for (char& c : name)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  const auto has = [&](const char* word) { return name.find(word) != std::string::npos; };
  if (has("sleeve") || (has("arm") && !has("armhole"))) return Kind::arm;
  if (has("leg") || has("pant") || has("trouser") || has("skirt")) return Kind::leg;
  return Kind::unknown;
}

/// Mean of angles, as a direction. [degrees]
double mean_angle(double cosine, double sine) {
  return std::atan2(sine, cosine) * 180 / std::numbers::pi;
}

/// How far points have gone along a line and about it.
struct Shift {
  double along = 0;  ///< [m]
  double angle = 0;  ///< [degrees]
};

class Examination {
 public:
  explicit Examination(const WornInput& input)
      : in_(input),
        figure_(input.body, input.up, input.segmentation),
        welded_(weld(input.cloth, input.sewn)),
        now_(figure_.lines(input.body.positions)),
        start_(input.cloth_start),
        triangle_panel_(panels()) {
    if (start_ != nullptr && start_->size() != in_.cloth.positions.size()) start_ = nullptr;
    const bool moved =
        in_.body_start != nullptr && in_.body_start->size() == in_.body.positions.size();
    then_ = moved ? figure_.lines(*in_.body_start) : now_;
  }

  std::vector<GarmentVerdict> verdicts() {
    std::vector<GarmentVerdict> all;
    for (Index c = 0; c < welded_.components; ++c) all.push_back(garment(c));
    return all;
  }

 private:
  /// Fills in panel_names_. @return [triangles] the panel of each
  std::vector<Index> panels() {
    const Mesh& m = in_.cloth;
    const std::size_t count = m.triangles.size();
    const bool parts = m.part.size() == count;
    if (parts || m.group.size() == count) {
      panel_names_ = parts ? m.part_names : m.group_names;
      return parts ? m.part : m.group;
    }
    panel_names_ = {"cloth"};
    return std::vector<Index>(count, 0);
  }

  const std::string& panel_name(Index panel) const {
    static const std::string none = "cloth";
    return panel >= 0 && at(panel) < panel_names_.size() ? panel_names_[at(panel)] : none;
  }

  double height() const { return figure_.height(); }

  std::string around_text(const Linking& l) const {
    std::string text;
    for (const BodyPart part : all_parts)
      if (l.around(part)) text += (text.empty() ? "" : ", ") + figure_.name(part);
    return text.empty() ? "nothing" : text;
  }

  static Points at_places(const std::vector<Index>& vertices, const Points& x) {
    Points points;
    for (const Index v : vertices) points.push_back(x[at(v)]);
    return points;
  }

  Shift shift(const std::vector<Index>& vertices, BodyPart part) const {
    Shift result;
    double cosine = 0, sine = 0;
    for (const Index v : vertices) {
      const LinePlace a = place_at((*start_)[at(v)], then_, part);
      const LinePlace b = place_at(in_.cloth.positions[at(v)], now_, part);
      result.along += (b.along - a.along) / static_cast<double>(vertices.size());
      cosine += std::min(a.distance, b.distance) * std::cos(b.angle - a.angle);
      sine += std::min(a.distance, b.distance) * std::sin(b.angle - a.angle);
    }
    result.angle = mean_angle(cosine, sine);
    return result;
  }

  /// Share of the sectors about a line in which there are points.
  double surrounds(const std::vector<Index>& vertices, BodyPart part) const {
    std::array<bool, sectors> hit{};
    for (const Index v : vertices) {
      const LinePlace place = place_at(in_.cloth.positions[at(v)], now_, part);
      hit[sector(place.angle)] = true;
    }
    return static_cast<double>(std::count(hit.begin(), hit.end(), true)) / sectors;
  }
  static std::size_t sector(double angle) {
    const double turn = angle / (2 * std::numbers::pi) + 0.5;
    return static_cast<std::size_t>(std::clamp(static_cast<int>(turn * sectors), 0, sectors - 1));
  }

  BodyPart nearest_part(const Vec3<double>& x, const BodyLines& lines,
                        const std::set<BodyPart>& among) const {
    BodyPart best = BodyPart::trunk;
    double distance = -1;
    for (const BodyPart part : among) {
      if (lines.line[index_of(part)].size() < 2) continue;
      const double d = place_at(x, lines, part).distance;
      if (distance < 0 || d < distance) {
        distance = d;
        best = part;
      }
    }
    return best;
  }

  GarmentVerdict garment(Index component) {
    GarmentVerdict verdict;
    std::set<BodyPart> parts{BodyPart::trunk};
    bool around_any = false;
    survey(component);
    loose_panels_.clear();
    for (std::size_t l = 0; l < welded_.loops.size(); ++l)
      if (welded_.loop_component[l] == component) around_any |= opening(l, parts, verdict);
    std::vector<Index> vertices = vertices_of(component);
    std::set<std::string> names;
    for (std::size_t t = 0; t < triangle_panel_.size(); ++t)
      if (welded_.component[t] == component) names.insert(panel_name(triangle_panel_[t]));
    for (const std::string& name : names) {
      if (verdict.name.size() > 60) {
        verdict.name += ", ...";
        break;
      }
      verdict.name += (verdict.name.empty() ? "" : ", ") + name;
    }
    if (!around_any && !open_around(vertices))
      verdict.faults.push_back("no opening is around a part of the body");
    if (start_ != nullptr) shoulders(vertices, verdict);
    panels_of(component, parts, verdict);
    if (back_to_front(component))
      verdict.faults.push_back("is worn back to front, by the names of its panels");
    return verdict;
  }

  /// Whether panels that are called front are on the whole behind those that are called back.
  bool back_to_front(Index component) const {
    const std::optional<Vec3<double>> ahead = looking(now_, in_.up);
    if (!ahead) return false;
    const Mesh& m = in_.cloth;
    const bool grouped = m.group.size() == m.triangles.size();
    double front = 0, back = 0, front_area = 0, back_area = 0;
    for (std::size_t t = 0; t < m.triangles.size(); ++t) {
      if (welded_.component[t] != component) continue;
      const PanelSide side = panel_side(grouped && at(m.group[t]) < m.group_names.size()
                                            ? m.group_names[at(m.group[t])]
                                            : panel_name(triangle_panel_[t]));
      if (side == PanelSide::unknown) continue;
      const double area = area_of(static_cast<Index>(t));
      double place = 0;
      for (const Index v : m.triangles[t].v) place += dot(m.positions[at(v)], *ahead) / 3;
      (side == PanelSide::front ? front : back) += place * area;
      (side == PanelSide::front ? front_area : back_area) += area;
    }
    return front_area > 0 && back_area > 0 &&
           front / front_area < back / back_area - clearly_behind * height();
  }

  /// Whether a garment without an opening around the body, such as an open coat, surrounds it.
  bool open_around(const std::vector<Index>& vertices) const {
    return surrounds(vertices, BodyPart::trunk) > 0.6;
  }

  std::vector<Index> vertices_of(Index component) const {
    std::set<Index> found;
    for (std::size_t t = 0; t < welded_.component.size(); ++t)
      if (welded_.component[t] == component)
        for (const Index v : in_.cloth.triangles[t].v) found.insert(v);
    return {found.begin(), found.end()};
  }

  double loop_length(std::size_t l) const {
    const Points x = at_places(welded_.loops[l], in_.cloth.positions);
    double sum = 0;
    for (std::size_t k = 0; k < x.size(); ++k) sum += length(x[(k + 1) % x.size()] - x[k]);
    return sum;
  }

  /// Part of the body that an opening is about: a limb, unless the trunk.
  static BodyPart part_of(const Linking& linking) {
    BodyPart part = BodyPart::trunk;
    if (!linking.around(BodyPart::trunk))
      for (const BodyPart p : all_parts)
        if (linking.around(p)) part = p;
    return part;
  }

  /// Fills in shortest_ and has_neck_.
  void survey(Index component) {
    shortest_.fill(std::numeric_limits<double>::infinity());
    has_neck_ = false;
    for (std::size_t l = 0; l < welded_.loops.size(); ++l) {
      if (welded_.loop_component[l] != component) continue;
      const Linking linking = link(at_places(welded_.loops[l], in_.cloth.positions), now_);
      if (linking.around_nothing()) continue;
      double& least = shortest_[index_of(part_of(linking))];
      least = std::min(least, loop_length(l));
      if (figure_.has_limbs() && linking.around(BodyPart::trunk) && !any_arm(linking))
        has_neck_ = has_neck_ || linking.trunk_at < arm_root(now_);
    }
  }

  static bool any_arm(const Linking& l) {
    return l.around(BodyPart::first_arm) || l.around(BodyPart::second_arm);
  }

  /// @return whether it is around anything
  bool opening(std::size_t l, std::set<BodyPart>& parts, GarmentVerdict& verdict) {
    const std::vector<Index>& loop = welded_.loops[l];
    const Points now = at_places(loop, in_.cloth.positions);
    OpeningVerdict o;
    std::set<std::string> names;
    bool arms = true, legs = true;
    for (const Index t : welded_.loop_triangles[l]) {
      const std::string& name = panel_name(triangle_panel_[at(t)]);
      names.insert(name);
      arms = arms && kind_of(name) == Kind::arm;
      legs = legs && kind_of(name) == Kind::leg;
    }
    for (const std::string& name : names) o.panels += (o.panels.empty() ? "" : ", ") + name;
    o.length = loop_length(l);
    const Linking end = link(now, now_);
    o.around = around_text(end);
    Linking begin;
    if (start_ != nullptr) {
      begin = link(at_places(loop, *start_), then_);
      o.around_at_start = around_text(begin);
    }
    for (const BodyPart part : all_parts)
      if (end.around(part) || begin.around(part)) parts.insert(part);
    const std::string where = "opening at " + o.panels;
    const bool long_enough = o.length > small_opening * height();
    const auto only_arm = [](const Linking& k) {
      return std::abs(k.turns[1]) + std::abs(k.turns[2]) == 1 && !k.around(BodyPart::trunk) &&
             !k.around(BodyPart::first_leg) && !k.around(BodyPart::second_leg);
    };
    const bool same = begin == end || near_arms(begin, end) || open_front(begin, end);
    if (!begin.around_nothing() && !same) {
      verdict.faults.push_back(fmt::format("{}: around {}, not {} as at the start", where, o.around,
                                           *o.around_at_start));
    } else if (arms && figure_.has_limbs() && long_enough && !only_arm(end)) {
      verdict.faults.push_back(fmt::format("{}: around {}, not one arm", where, o.around));
    } else if (legs && any_arm(end)) {
      verdict.faults.push_back(
          fmt::format("{}: around {}, not the trunk or a leg", where, o.around));
    } else if (end.around_nothing() && long_enough && surrounds(loop, BodyPart::trunk) <= 0.5 &&
               !before_face(loop)) {
      verdict.faults.push_back(where + ": around nothing");
    } else if (!end.around_nothing() && !both_arms(end) && start_ != nullptr && same) {
      moved(loop, welded_.loop_triangles[l], end, where, o, verdict);
    } else if (end.around(BodyPart::trunk) && any_arm(end)) {
      // Without a start: an arm is inside of what is around the trunk.
      if (start_ == nullptr && !at_arms(end, now_) && !below_cape(end))
        verdict.faults.push_back(fmt::format("{}: around {} at once", where, o.around));
    }
    verdict.openings.push_back(std::move(o));
    return !end.around_nothing();
  }

  /// Whether an opening that is around nothing is that of a hood: above the arms, and where it was
  /// at the start if that is known.
  bool before_face(const std::vector<Index>& loop) const {
    if (!figure_.has_limbs()) return false;
    double mean = 0;
    for (const Index v : loop)
      mean += place_at(in_.cloth.positions[at(v)], now_, BodyPart::trunk).along /
              static_cast<double>(loop.size());
    return mean < arm_root(now_) &&
           (start_ == nullptr ||
            std::abs(shift(loop, BodyPart::trunk).along) < in_.limits.slide * height());
  }

  /// [m] along the trunk, where the arms begin
  static double arm_root(const BodyLines& lines) {
    double root = 0;
    for (const std::size_t p : {std::size_t{1}, std::size_t{2}})
      root += place_at(lines.line[p][0], lines, BodyPart::trunk).along / 2;
    return root;
  }

  /// Whether two linkings around the trunk differ in arms alone, of an opening at their roots: the
  /// upper edge of a strapless dress is on either side of them.
  bool near_arms(const Linking& begin, const Linking& end) const {
    if (!figure_.has_limbs() || !begin.around(BodyPart::trunk) || !end.around(BodyPart::trunk) ||
        begin.around(BodyPart::first_leg) != end.around(BodyPart::first_leg) ||
        begin.around(BodyPart::second_leg) != end.around(BodyPart::second_leg))
      return false;
    return at_arms(begin, then_);
  }

  /// Whether a linking is with both arms alone.
  static bool both_arms(const Linking& l) {
    return l.around(BodyPart::first_arm) && l.around(BodyPart::second_arm) &&
           !l.around(BodyPart::trunk) && !l.around(BodyPart::first_leg) &&
           !l.around(BodyPart::second_leg);
  }

  /// Whether an opening is the hem of a poncho: it is around both arms and the trunk, and another
  /// one of the garment is around the trunk above the arms.
  bool below_cape(const Linking& l) const {
    return has_neck_ && l.around(BodyPart::first_arm) && l.around(BodyPart::second_arm);
  }

  /// Whether two linkings differ in both arms at once, and in nothing else. The opening of an open
  /// coat runs up one front, around the neck and down the other: hand and hand are joined by a line
  /// through the trunk, which it passes on either side.
  bool open_front(const Linking& begin, const Linking& end) const {
    return figure_.has_limbs() && ((both_arms(begin) && end.around_nothing()) ||
                                   (begin.around_nothing() && both_arms(end)));
  }

  /// Whether an opening around the trunk is at the height where arms begin.
  bool at_arms(const Linking& linking, const BodyLines& lines) const {
    if (!figure_.has_limbs()) return false;
    const double root = place_at(lines.line[1][0], lines, BodyPart::trunk).along;
    return std::abs(linking.trunk_at - root) < 0.04 * height();
  }

  /// How far an opening has gone along and about what it is around.
  void moved(const std::vector<Index>& loop, const std::vector<Index>& loop_triangles,
             const Linking& end, const std::string& where, OpeningVerdict& o,
             GarmentVerdict& verdict) {
    const BodyPart part = part_of(end);
    const Shift s = shift(loop, part);
    o.slide = s.along;
    o.twist = s.angle;
    const double most = (part == BodyPart::trunk ? in_.limits.slide : in_.limits.drift) * height();
    // A wide hem stands where its panels start, and then falls or flares: the waist or the neck
    // says whether the garment has slid. No flare lifts it as far as a panel may go.
    const bool loose = o.length > loose_opening * shortest_[index_of(part)] &&
                       s.along > -in_.limits.drift * height();
    if (loose)
      for (const Index t : loop_triangles) loose_panels_.insert(triangle_panel_[at(t)]);
    if (std::abs(s.along) > most && !loose)
      verdict.faults.push_back(fmt::format("{}: has slid {:.3f} m {} {}", where, std::abs(s.along),
                                           s.along > 0 ? "down" : "up", figure_.name(part)));
    if (std::abs(s.angle) > in_.limits.twist)
      verdict.faults.push_back(fmt::format("{}: has turned {:.0f} degrees about {}", where,
                                           std::abs(s.angle), figure_.name(part)));
  }

  /// Cells about the upper trunk, where the arms begin, in which there is cloth: rows down the
  /// trunk, sectors about it.
  /// @param below rows below those of the shoulders
  std::set<std::pair<int, std::size_t>> shoulder_cells(const std::vector<Index>& vertices,
                                                       const Points& x, const BodyLines& lines,
                                                       int below) const {
    const double root = arm_root(lines);
    std::set<std::pair<int, std::size_t>> cells;
    for (const Index v : vertices) {
      const LinePlace place = place_at(x[at(v)], lines, BodyPart::trunk);
      const double row = (place.along - root) / (cell_rows * height());
      if (place.distance < 0.2 * height() && row > -2 && row < 1 + below)
        cells.insert({static_cast<int>(std::floor(row)), sector(place.angle)});
    }
    return cells;
  }

  /// A cell is still covered by cloth that is as far below as an opening may slide.
  void shoulders(const std::vector<Index>& vertices, GarmentVerdict& verdict) {
    if (!figure_.has_limbs()) return;
    const int slack = static_cast<int>(std::lround(in_.limits.slide / cell_rows));
    const auto then = shoulder_cells(vertices, *start_, then_, 0);
    const auto now = shoulder_cells(vertices, in_.cloth.positions, now_, slack);
    if (then.size() < sectors) return;
    double kept = 0;
    for (const auto& [row, sector] : then)
      for (int below = 0; below <= slack; ++below)
        if (now.contains({row + below, sector})) {
          kept += 1;
          break;
        }
    verdict.shoulders = kept / static_cast<double>(then.size());
    if (*verdict.shoulders < in_.limits.covered)
      verdict.faults.push_back(
          fmt::format("covers {:.0f} % of what it covered of the shoulders at the start",
                      100 * *verdict.shoulders));
  }

  /// Mean of the signs of normals away from a line, by area.
  double outward(const std::vector<Index>& triangles, const Points& x, const BodyLines& lines,
                 BodyPart part) const {
    double sum = 0, area = 0;
    for (const Index t : triangles) {
      const auto& v = in_.cloth.triangles[at(t)].v;
      const Vec3<double> a = x[at(v[0])], b = x[at(v[1])], c = x[at(v[2])];
      const Vec3<double> normal = cross(b - a, c - a);
      const LinePlace place = place_at((a + b + c) * (1.0 / 3), lines, part);
      area += length(normal);
      sum += dot(normal, place.away) > 0 ? length(normal) : -length(normal);
    }
    return area > 0 ? sum / area : 0;
  }

  double area_of(Index t) const {
    const auto& v = in_.cloth.triangles[at(t)].v;
    const Points& x = in_.cloth.positions;
    return length(cross(x[at(v[1])] - x[at(v[0])], x[at(v[2])] - x[at(v[0])])) / 2;
  }

  /// The larger principal stretch from the rest shape; none: it is not known.
  std::optional<double> stretch_of(Index t) const {
    const Mesh& m = in_.cloth;
    const auto& v = m.triangles[at(t)].v;
    const Points& x = m.positions;
    const Vec3<double> a = x[at(v[1])] - x[at(v[0])], b = x[at(v[2])] - x[at(v[0])];
    double r00 = 0, r01 = 0, r11 = 0;  // rest edges in a plane: (r00, 0), (r01, r11)
    if (!m.material.empty()) {
      const auto& u = (m.material_triangles.empty() ? m.triangles : m.material_triangles)[at(t)].v;
      const Vec2<double> p = m.material[at(u[1])] - m.material[at(u[0])];
      const Vec2<double> q = m.material[at(u[2])] - m.material[at(u[0])];
      r00 = std::hypot(p[0], p[1]);
      r01 = r00 > 0 ? (p[0] * q[0] + p[1] * q[1]) / r00 : 0;
      r11 = r00 > 0 ? std::abs(p[0] * q[1] - p[1] * q[0]) / r00 : 0;
    } else if (start_ != nullptr) {
      const Vec3<double> p = (*start_)[at(v[1])] - (*start_)[at(v[0])];
      const Vec3<double> q = (*start_)[at(v[2])] - (*start_)[at(v[0])];
      r00 = length(p);
      r01 = r00 > 0 ? dot(p, q) / r00 : 0;
      r11 = r00 > 0 ? length(cross(p, q)) / r00 : 0;
    }
    if (!(r00 > 0 && r11 > 0)) return std::nullopt;
    const Vec3<double> f0 = a * (1 / r00), f1 = (b - f0 * r01) * (1 / r11);
    const double c00 = dot(f0, f0), c11 = dot(f1, f1), c01 = dot(f0, f1);
    const double mean = (c00 + c11) / 2;
    return std::sqrt(mean + std::hypot((c00 - c11) / 2, c01));
  }

  void panels_of(Index component, const std::set<BodyPart>& parts, GarmentVerdict& verdict) {
    std::vector<std::vector<Index>> triangles(std::max<std::size_t>(panel_names_.size(), 1));
    double whole = 0;
    for (std::size_t t = 0; t < triangle_panel_.size(); ++t) {
      if (welded_.component[t] != component) continue;
      triangles[std::min(at(std::max(triangle_panel_[t], Index{0})), triangles.size() - 1)]
          .push_back(static_cast<Index>(t));
      whole += area_of(static_cast<Index>(t));
    }
    for (std::size_t p = 0; p < triangles.size(); ++p)
      if (!triangles[p].empty())
        verdict.panels.push_back(
            panel(static_cast<Index>(p), triangles[p], parts, whole, verdict.faults));
  }

  PanelVerdict panel(Index number, const std::vector<Index>& triangles,
                     const std::set<BodyPart>& parts, double whole,
                     std::vector<std::string>& faults) {
    PanelVerdict v;
    v.name = panel_name(number);
    std::set<Index> found;
    for (const Index t : triangles)
      for (const Index w : in_.cloth.triangles[at(t)].v) found.insert(w);
    const std::vector<Index> vertices(found.begin(), found.end());
    std::array<std::size_t, body_part_count> near{};
    for (const Index w : vertices)
      ++near[index_of(start_ != nullptr ? nearest_part((*start_)[at(w)], then_, parts)
                                        : nearest_part(in_.cloth.positions[at(w)], now_, parts))];
    const auto part =
        static_cast<BodyPart>(std::max_element(near.begin(), near.end()) - near.begin());
    v.part = figure_.name(part);
    double area = 0, stretched = 0;
    for (const Index t : triangles) {
      const double a = area_of(t);
      area += a;
      const std::optional<double> s = stretch_of(t);
      if (!s) continue;
      v.stretch = std::max(v.stretch.value_or(0), *s);
      if (*s > in_.limits.stretch) stretched += a;
    }
    v.stretched = area > 0 ? stretched / area : 0;
    v.outward = outward(triangles, in_.cloth.positions, now_, part);
    const std::string where = "panel " + v.name;
    if (v.stretched > in_.limits.stretched)
      faults.push_back(
          fmt::format("{}: {:.0f} % of its area is stretched to over {:.3g}, at most {:.3g}", where,
                      100 * v.stretched, in_.limits.stretch, *v.stretch));
    if (start_ == nullptr) return v;
    v.outward_at_start = outward(triangles, *start_, then_, part);
    const Shift s = shift(vertices, part);
    v.drift = s.along;
    v.twist = s.angle;
    if (area < small_panel * whole) return v;
    if (std::abs(s.along) > in_.limits.drift * height() && !loose_panels_.contains(number))
      faults.push_back(fmt::format("{}: has gone {:.3f} m {} {}", where, std::abs(s.along),
                                   s.along > 0 ? "down" : "up", v.part));
    if (std::abs(s.angle) > in_.limits.twist)
      faults.push_back(
          fmt::format("{}: has turned {:.0f} degrees about {}", where, std::abs(s.angle), v.part));
    if (std::abs(*v.outward_at_start) > 0.5 && v.outward * *v.outward_at_start < 0 &&
        std::abs(v.outward) > 0.3)
      faults.push_back(where + ": is inside out");
    return v;
  }

  const WornInput& in_;
  BodyFigure figure_;
  Welded welded_;
  BodyLines now_, then_;
  const Points* start_;
  std::vector<std::string> panel_names_;
  std::vector<Index> triangle_panel_;
  // of the garment that is looked at:
  std::array<double, body_part_count> shortest_{};  ///< [parts] [m] shortest opening around each
  bool has_neck_ = false;         ///< an opening around the trunk alone is above the arms
  std::set<Index> loose_panels_;  ///< at a wide hem, with which they move
};

}  // namespace

std::vector<GarmentVerdict> worn(const WornInput& input) {
  return Examination(input).verdicts();
}

}  // namespace weft::lab
