#include "host/implicit/collision_response/separating_planes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "weft/core/at.hpp"
#include "weft/elements/distance.hpp"

namespace weft {
namespace {

constexpr int sweeps_max = 20;
/// Share of the gap at the start that is kept. With smaller shares gaps soon are so small that
/// nothing can move.
constexpr double gap_share = 0.8;
/// [thicknesses] Smaller gaps do not shrink.
constexpr double gap_least = 0.02;
/// The normal of the impact is taken if the gap along it at the start is at least this share of the
/// distance.
constexpr double impact_normal_share = 0.3;
/// A plane is kept up to this share of its gap.
constexpr double kept_share = 0.99;

constexpr double infinite = std::numeric_limits<double>::infinity();

/// What lies between the two sides of a plane, along its normal.
struct Gap {
  double above = infinite;
  double below = -infinite;

  void add(bool upper, double height) {
    if (upper)
      above = std::min(above, height);
    else
      below = std::max(below, height);
  }
  double size() const { return above - below; }
};

}  // namespace

template <class T>
void SeparatingPlanes<T>::begin(const std::vector<Vec3<T>>& from, const std::vector<Vec3<T>>& to,
                                const std::vector<unsigned char>& held, double thickness) {
  from_ = &from;
  held_ = &held;
  thickness_ = thickness;
  ends_.clear();
  ends_.reserve(to.size());
  for (const Vec3<T>& x : to) ends_.push_back(vec_cast<double>(x));
  planes_.clear();
  pairs_.clear();
}

template <class T>
void SeparatingPlanes<T>::add(Span<const Collision> collisions) {
  for (const Collision& c : collisions) {
    if (!pairs_.insert({c.first, c.v[0], c.v[1], c.v[2], c.v[3]}).second) continue;
    Vec3<double> x[4];
    Gap along_impact;
    for (int j = 0; j < 4; ++j) {
      x[j] = vec_cast<double>((*from_)[at(c.v[j])]);
      along_impact.add(j < c.first, dot(c.n, x[j]));
    }
    const Proximity<double> closest = c.first == 1 ? vertex_triangle(x) : edge_edge(x);
    const double distance = std::sqrt(closest.distance_sq);
    const bool take_impact =
        !(distance > 0) || along_impact.size() > impact_normal_share * distance;
    const double gap = take_impact ? along_impact.size() : distance;
    planes_.push_back({{c.v[0], c.v[1], c.v[2], c.v[3]},
                       c.first,
                       take_impact ? c.n : (1 / distance) * closest.difference,
                       std::max(gap_share * gap, std::min(gap, gap_least * thickness_))});
  }
}

template <class T>
void SeparatingPlanes<T>::keep(bool held_too) {
  for (int sweep = 0; sweep < sweeps_max; ++sweep) {
    bool all_kept = true;
    for (const Plane& plane : planes_) all_kept = keep(plane, held_too) && all_kept;
    if (all_kept) return;
  }
}

/// @return whether the plane has been kept by all ends as they were
template <class T>
bool SeparatingPlanes<T>::keep(const Plane& plane, bool held_too) {
  const auto height_of = [&](Index v) { return dot(plane.n, ends_[at(v)]); };
  Gap gap;
  Gap held_gap;
  for (int j = 0; j < 4; ++j) {
    const double height = height_of(plane.v[j]);
    gap.add(j < plane.first, height);
    if (held(plane.v[j])) held_gap.add(j < plane.first, height);
  }
  if (gap.size() >= kept_share * plane.gap) return true;
  const bool held_above = held_gap.above < infinite;
  const bool held_below = held_gap.below > -infinite;
  const double half = plane.gap / 2;
  double middle = (gap.above + gap.below) / 2;
  if (!held_too && held_above != held_below)
    middle = held_above ? held_gap.above - half : held_gap.below + half;
  for (int j = 0; j < 4; ++j) {
    const Index v = plane.v[j];
    if (held(v) && !held_too) continue;
    const bool upper = j < plane.first;
    const double height = height_of(v);
    double move =
        upper ? std::max(0.0, middle + half - height) : std::min(0.0, middle - half - height);
    if (held(v)) {
      const double back = dot(plane.n, vec_cast<double>((*from_)[at(v)])) - height;
      move = upper ? std::min(move, std::max(0.0, back)) : std::max(move, std::min(0.0, back));
    }
    if (move != 0) ends_[at(v)] += move * plane.n;
  }
  return false;
}

template class SeparatingPlanes<float>;
template class SeparatingPlanes<double>;

}  // namespace weft
