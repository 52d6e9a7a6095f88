#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "weft/scene.hpp"

namespace weft::lab {

/// Parts of a body that garments are around. `trunk` reaches from the crown to the crotch.
enum class BodyPart { trunk, first_arm, second_arm, first_leg, second_leg };
inline constexpr std::size_t body_part_count = 5;

/// Vertices of a body by name, as in a segmentation file.
using BodySegmentation = std::vector<std::pair<std::string, std::vector<Index>>>;

/// Centre lines of a body in one pose. [m]
struct BodyLines {
  /// [parts][points] from the crown down, and from the trunk to the tips of the limbs; empty: the
  /// body has no such part
  std::array<std::vector<Vec3<double>>, body_part_count> line;
  /// [parts][points] unit, across the line: the direction that angles about it count from. It is
  /// to the front, and turns as the surface around the line does from pose to pose.
  std::array<std::vector<Vec3<double>>, body_part_count> ahead;
};

/// Which vertex of a body belongs to which part.
class BodyFigure {
 public:
  /// Finds the limbs by geodesic distances on the surface, whatever the pose: hands, feet and crown
  /// are its five tips. A body without these is all trunk. Only the largest component counts.
  /// @param up           unit, which end of a body without limbs is the upper one
  /// @param segmentation names that contain arm, hand or elbow; leg, foot or knee; left and right.
  ///                     All else is trunk. Empty: found
  BodyFigure(const Mesh& body, const Vec3<double>& up, const BodySegmentation& segmentation = {});

  bool has_limbs() const { return has_limbs_; }
  double height() const { return height_; }  ///< [m] along trunk and legs
  /// Name of a part for messages; arms and legs say on which side they are.
  const std::string& name(BodyPart part) const { return names_[static_cast<std::size_t>(part)]; }

  /// Centre lines in a pose.
  /// @param positions [vertices] of the body
  BodyLines lines(const std::vector<Vec3<double>>& positions) const;

 private:
  void find_limbs();
  bool has_all_parts() const;
  void take(const BodySegmentation& segmentation);
  void measure(const Vec3<double>& up);

  /// Parts cut into slices by `along_`, in one pose.
  struct Slices {
    std::array<std::vector<Vec3<double>>, body_part_count> centre;  ///< [parts][slices]
    /// [parts][slices] unit, across the line through the centres: to the front of the body, and
    /// from slice to slice with as little turn as possible
    std::array<std::vector<Vec3<double>>, body_part_count> across;
    std::array<std::vector<std::size_t>, body_part_count> number;  ///< [parts][slices] not empty
  };
  Slices cut(const std::vector<Vec3<double>>& positions) const;
  void remember_places();
  void turn_with_surface(const std::vector<Vec3<double>>& positions, Slices& pose) const;
  Vec2<double> place_in(const Slices& pose, std::size_t part, std::size_t k,
                        const Vec3<double>& x) const;
  /// [vertices] where the slice of each is in Slices::centre of its part; -1: nowhere
  std::vector<int> slice_of(const Slices& pose) const;
  void name_sides();

  std::vector<Vec3<double>> positions_;
  std::vector<std::vector<Index>> neighbours_;
  std::vector<BodyPart> part_;  ///< [vertices]
  /// [vertices] [m] on the surface: from the crown in the trunk, from the trunk in limbs; infinite
  /// if it counts for nothing
  std::vector<double> along_;
  std::array<double, body_part_count> reach_{};  ///< [parts] [m] largest `along_`
  /// [vertices] [m] from the centre of a vertex's slice: ahead, and to the side. Empty: not yet
  /// known
  std::vector<Vec2<double>> place_;
  Index crown_ = -1;
  bool has_limbs_ = false;
  double height_ = 0;
  std::array<std::string, body_part_count> names_;
};

}  // namespace weft::lab
