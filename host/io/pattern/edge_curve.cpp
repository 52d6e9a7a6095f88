#include "host/io/pattern/edge_curve.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "weft/core/at.hpp"

namespace weft::io {
namespace {

/// Steps of the parameter at which lengths are known. Chords of a curve that turns by 360 degrees
/// are then shorter than their arcs by 2e-6 of their length.
constexpr int curve_parts = 1024;

}  // namespace

EdgeCurve::EdgeCurve(const PatternPanel& panel, const PatternEdge& edge)
    : from_(panel.vertices[at(edge.from)]), to_(panel.vertices[at(edge.to)]), edge_(edge) {
  if (edge.shape == PatternEdge::Shape::arc) {
    const Vec2<double> chord = to_ - from_;
    const double half = weft::length(chord) / 2;
    const double height = std::sqrt(std::max(edge.radius * edge.radius - half * half, 0.0));
    // An arc to the left has its centre on its left, unless it is more than half a circle.
    const double side = edge.left != edge.large ? 1 : -1;
    const Vec2<double> across{-chord[1] / (2 * half), chord[0] / (2 * half)};
    centre_ = (from_ + to_) * 0.5 + across * (side * height);
    const Vec2<double> a = from_ - centre_, b = to_ - centre_;
    start_ = std::atan2(a[1], a[0]);
    sweep_ = std::atan2(b[1], b[0]) - start_;
    if (edge.left && sweep_ < 0) sweep_ += 2 * std::numbers::pi;
    if (!edge.left && sweep_ > 0) sweep_ -= 2 * std::numbers::pi;
  }
  const bool polyline = edge.shape == PatternEdge::Shape::polyline;
  const std::size_t steps = polyline ? edge.controls.size() + 1 : curve_parts;
  lengths_.assign(steps + 1, 0);
  Vec2<double> last = from_;
  for (std::size_t k = 1; k <= steps; ++k) {
    const Vec2<double> now =
        polyline ? corner(k) : point(static_cast<double>(k) / static_cast<double>(steps));
    lengths_[k] = lengths_[k - 1] + weft::length(now - last);
    last = now;
  }
}

Vec2<double> EdgeCurve::corner(std::size_t k) const {
  return k == 0 ? from_ : k > edge_.controls.size() ? to_ : edge_.controls[k - 1];
}

Vec2<double> EdgeCurve::point(double t) const {
  const double s = 1 - t;
  if (edge_.shape == PatternEdge::Shape::line) return from_ * s + to_ * t;
  if (edge_.shape == PatternEdge::Shape::arc) {
    const double angle = start_ + t * sweep_;
    return centre_ + Vec2<double>{std::cos(angle), std::sin(angle)} * edge_.radius;
  }
  if (edge_.shape == PatternEdge::Shape::polyline) {
    const double place = t * static_cast<double>(edge_.controls.size() + 1);
    const auto k = std::min(static_cast<std::size_t>(place), edge_.controls.size());
    const double share = place - static_cast<double>(k);
    return corner(k) * (1 - share) + corner(k + 1) * share;
  }
  if (edge_.controls.size() == 1)
    return from_ * (s * s) + edge_.controls[0] * (2 * s * t) + to_ * (t * t);
  return from_ * (s * s * s) + edge_.controls[0] * (3 * s * s * t) +
         edge_.controls[1] * (3 * s * t * t) + to_ * (t * t * t);
}

std::vector<double> EdgeCurve::even_distances(Index segments) const {
  std::vector<double> distances;
  for (Index i = 0; i <= segments; ++i) distances.push_back(length() * i / segments);
  return distances;
}

EdgeCurve::Nearest EdgeCurve::nearest(const Vec2<double>& place) const {
  const std::size_t steps = lengths_.size() - 1;
  Nearest best{0, weft::length(place - from_)};
  Vec2<double> a = from_;
  for (std::size_t k = 1; k <= steps; ++k) {
    const Vec2<double> b = point(static_cast<double>(k) / static_cast<double>(steps));
    const double sq = length_sq(b - a);
    const double share = sq > 0 ? std::clamp(dot(place - a, b - a) / sq, 0.0, 1.0) : 0;
    const double away = weft::length(place - (a + (b - a) * share));
    if (away < best.away) best = {lengths_[k - 1] + share * (lengths_[k] - lengths_[k - 1]), away};
    a = b;
  }
  return best;
}

std::vector<Vec2<double>> EdgeCurve::sample(const std::vector<double>& distances) const {
  std::vector<Vec2<double>> points{from_};
  const std::size_t steps = lengths_.size() - 1;
  std::size_t k = 0;
  for (std::size_t i = 1; i + 1 < distances.size(); ++i) {
    const double wanted = distances[i];
    while (k + 1 < steps && lengths_[k + 1] < wanted) ++k;
    const double step = lengths_[k + 1] - lengths_[k];
    const double share = step > 0 ? std::clamp((wanted - lengths_[k]) / step, 0.0, 1.0) : 0;
    points.push_back(point((static_cast<double>(k) + share) / static_cast<double>(steps)));
  }
  points.push_back(to_);
  return points;
}

}  // namespace weft::io
