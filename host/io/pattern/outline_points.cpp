#include "host/io/pattern/outline_points.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>

#include "host/input/counted.hpp"
#include "host/io/pattern/outline_file.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

/// [degrees] by which an outline turns at a point
double turn_at(const std::vector<Vec2<double>>& points, std::size_t k) {
  const std::size_t n = points.size();
  const Vec2<double> a = points[k] - points[(k + n - 1) % n], b = points[(k + 1) % n] - points[k];
  const double turn = std::atan2(a[0] * b[1] - a[1] * b[0], dot(a, b));
  return std::abs(turn) * 180 / std::numbers::pi;
}

/// Distance from a line. @param along unit
double distance(const Vec2<double>& p, const Vec2<double>& on, const Vec2<double>& along) {
  const Vec2<double> d = p - on;
  return std::abs(along[0] * d[1] - along[1] * d[0]);
}

}  // namespace

Vec2<double> mirrored(const Vec2<double>& p, const Vec2<double>& on, const Vec2<double>& along) {
  const Vec2<double> d = p - on;
  return on + along * (2 * dot(d, along)) - d;
}

void drop_repeated(OutlinePoints& outline) {
  OutlinePoints kept;
  for (std::size_t k = 0; k < outline.points.size(); ++k) {
    const bool repeats =
        !kept.points.empty() && length(outline.points[k] - kept.points.back()) < least_outline_edge;
    if (repeats) {
      kept.corner.back() |= outline.corner[k];
      continue;
    }
    kept.points.push_back(outline.points[k]);
    kept.corner.push_back(outline.corner[k]);
  }
  while (kept.points.size() > 1 &&
         length(kept.points.back() - kept.points.front()) < least_outline_edge) {
    kept.corner.front() |= kept.corner.back();
    kept.points.pop_back();
    kept.corner.pop_back();
  }
  outline = std::move(kept);
}

void find_corners(OutlinePoints& outline) {
  for (std::size_t k = 0; k < outline.points.size(); ++k)
    outline.corner[k] = turn_at(outline.points, k) > corner_angle ? 1 : 0;
}

bool unfold(OutlinePoints& outline, const Vec2<double>& a, const Vec2<double>& b) {
  const std::size_t n = outline.points.size();
  if (!(length(b - a) > same_place)) return false;
  const Vec2<double> along = (b - a) * (1 / length(b - a));
  std::size_t first = n, last = n;  // of the points on the line
  const auto place = [&](std::size_t k) { return dot(outline.points[k] - a, along); };
  for (std::size_t k = 0; k < n; ++k) {
    if (distance(outline.points[k], a, along) > same_place) continue;
    if (first == n || place(k) < place(first)) first = k;
    if (last == n || place(k) > place(last)) last = k;
  }
  if (first == n || first == last) return false;
  const auto lies_along = [&](std::size_t from, std::size_t to) {
    for (std::size_t k = from; k != to; k = (k + 1) % n)
      if (distance(outline.points[k], a, along) > same_place) return false;
    return true;
  };
  if (!lies_along(first, last)) std::swap(first, last);
  if (!lies_along(first, last)) return false;
  // From the end of the fold around to its beginning, and the mirror image of that backwards.
  OutlinePoints whole;
  for (std::size_t k = last;; k = (k + 1) % n) {
    whole.points.push_back(outline.points[k]);
    whole.corner.push_back(outline.corner[k]);
    if (k == first) break;
  }
  const std::size_t half = whole.points.size();
  for (std::size_t k = half - 2; k > 0; --k) {
    whole.points.push_back(mirrored(whole.points[k], a, along));
    whole.corner.push_back(whole.corner[k]);
  }
  for (const std::size_t k : {std::size_t{0}, half - 1})
    whole.corner[k] = turn_at(whole.points, k) > corner_angle ? 1 : 0;
  outline = std::move(whole);
  return outline.points.size() >= 3;
}

void take_outline(const OutlinePoints& outline, const std::string& file, const std::string& field,
                  PatternPanel& panel) {
  const std::size_t n = outline.points.size();
  if (n < 3) throw SceneError(file, field, counted(n, "point"), "at least 3");
  std::vector<std::size_t> corners;
  for (std::size_t k = 0; k < n; ++k)
    if (outline.corner[k] != 0) corners.push_back(k);
  // A round panel still needs two edges.
  if (corners.empty()) corners = {0, n / 2};
  if (corners.size() == 1) {
    corners.push_back((corners[0] + n / 2) % n);
    std::sort(corners.begin(), corners.end());
  }
  if (corners.size() > most_outline_corners)
    throw SceneError(file, field, counted(corners.size(), "corner"),
                     "up to " + std::to_string(most_outline_corners));
  for (std::size_t c = 0; c < corners.size(); ++c) {
    const std::size_t next = (c + 1) % corners.size();
    panel.vertices.push_back(outline.points[corners[c]]);
    PatternEdge edge;
    edge.from = static_cast<Index>(c);
    edge.to = static_cast<Index>(next);
    for (std::size_t k = (corners[c] + 1) % n; k != corners[next]; k = (k + 1) % n)
      edge.controls.push_back(outline.points[k]);
    if (!edge.controls.empty()) edge.shape = PatternEdge::Shape::polyline;
    panel.edges.push_back(std::move(edge));
  }
  for (std::size_t e = 0; e < panel.edges.size(); ++e) {
    const PatternEdge& edge = panel.edges[e];
    const Vec2<double> chord = panel.vertices[static_cast<std::size_t>(edge.to)] -
                               panel.vertices[static_cast<std::size_t>(edge.from)];
    if (!(length(chord) >= least_outline_edge))
      throw SceneError(file, field + ".edges[" + std::to_string(e) + "]", "ends at one place",
                       "ends that are at least 0.01 mm apart");
  }
}

}  // namespace weft::io
