#include "host/io/pattern/arm_clearance.hpp"

#include <algorithm>
#include <limits>
#include <vector>

#include "weft/core/at.hpp"

namespace weft::io {
namespace {

constexpr double column = 0.01;      ///< [m] width of those in which the body is looked at
constexpr double least_step = 0.1;   ///< [m] from the armpit down to the hips
constexpr double arm_gap = 0.02;     ///< [m] below an arm
constexpr double compressed = 0.15;  ///< [m] height below an arm into which cloth is compressed
constexpr double nothing = std::numeric_limits<double>::infinity();

/// The lower side of an arm, by the distance from the middle of the body.
class ArmUnderside {
 public:
  /// @param sign 1 or -1: to which side of the middle
  ArmUnderside(const Mesh& body, double middle, double sign) {
    double reach = 0;
    for (const Vec3<double>& p : body.positions) reach = std::max(reach, sign * (p[0] - middle));
    low_.assign(at(column_of(reach) + 1), nothing);
    for (const Tri& t : body.triangles) {
      double least = nothing, from = nothing, to = -nothing;
      for (const Index v : t.v) {
        const Vec3<double>& p = body.positions[at(v)];
        least = std::min(least, p[1]);
        from = std::min(from, sign * (p[0] - middle));
        to = std::max(to, sign * (p[0] - middle));
      }
      if (to < 0) continue;
      for (Index k = column_of(from); k <= column_of(to); ++k)
        low_[at(k)] = std::min(low_[at(k)], least);
    }
    // From the hand to the armpit it rises; then come the hips.
    double highest = -nothing;
    for (first_ = static_cast<Index>(low_.size()); first_ > 0; --first_) {
      const double low = low_[at(first_ - 1)];
      if (low < highest - least_step) break;
      if (low < nothing) highest = std::max(highest, low);
    }
    armpit_ = highest;
  }

  bool found() const { return first_ > 0; }
  /// [m] height
  double armpit() const { return armpit_; }
  /// [m] from the middle of the body
  double trunk() const { return static_cast<double>(first_) * column; }
  /// [m] height above which cloth must not stand; infinite beside the trunk
  double limit(double distance) const {
    if (distance < trunk()) return nothing;
    const Index k = std::min(column_of(distance), static_cast<Index>(low_.size()) - 1);
    // Triangles reach over several columns, and beyond the hand the skirt goes on.
    double low = nothing;
    for (Index j = std::max(k - 3, first_);
         j <= std::min(k + 3, static_cast<Index>(low_.size()) - 1); ++j)
      low = std::min(low, low_[at(j)]);
    return low - arm_gap;
  }

 private:
  static Index column_of(double distance) {
    return static_cast<Index>(std::max(distance, 0.0) / column);
  }

  std::vector<double> low_;  ///< [columns] [m] height of the lowest point
  Index first_ = 0;          ///< column of the armpit; 0: there is no arm
  double armpit_ = 0;
};

}  // namespace

void clear_arms(Garment& garment, const Mesh& body) {
  if (body.positions.empty()) return;
  double low = nothing, high = -nothing;
  for (const Vec3<double>& p : body.positions) {
    low = std::min(low, p[0]);
    high = std::max(high, p[0]);
  }
  const double middle = (low + high) / 2;
  for (const double sign : {1.0, -1.0}) {
    const ArmUnderside arm(body, middle, sign);
    if (!arm.found()) continue;
    for (const GarmentPanel& panel : garment.panels) {
      const auto first = garment.mesh.positions.begin() + panel.first_vertex;
      const auto last = first + panel.vertex_count;
      double top = -nothing, nearest = nothing;
      for (auto p = first; p != last; ++p) {
        top = std::max(top, (*p)[1]);
        nearest = std::min(nearest, sign * ((*p)[0] - middle));
      }
      if (nearest > arm.trunk() || (panel.label != "leg" && top > arm.armpit())) continue;
      for (auto p = first; p != last; ++p) {
        const double limit = arm.limit(sign * ((*p)[0] - middle));
        const double from = limit - compressed;
        if (top > limit && (*p)[1] > from)
          (*p)[1] = from + ((*p)[1] - from) * compressed / (top - from);
      }
    }
  }
}

}  // namespace weft::io
