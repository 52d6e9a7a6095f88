#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/lab/worn/body_figure.hpp"
#include "weft/scene.hpp"

/// Whether garments are worn: around the parts of the body that they were made for. It takes
/// meshes, and shares no code with what simulates them.
namespace weft::lab {

/// What is still worn. Lengths are shares of the body's height along trunk and legs.
struct WornLimits {
  double slide = 0.06;      ///< of an opening along the trunk or a limb
  double drift = 0.1;       ///< of a panel along the part of the body that it is at
  double twist = 60;        ///< [degrees] of an opening or a panel about that part
  double stretch = 1.25;    ///< largest principal stretch; beyond it at most:
  double stretched = 0.02;  ///< of a panel's area
  double covered = 0.5;  ///< of what a garment covers of the shoulders, or of a part, at the start
};

/// An opening of a garment: a closed boundary.
struct OpeningVerdict {
  std::string panels;  ///< names of those at its edge
  std::string around;  ///< parts that it is around at the end; "nothing"
  std::optional<std::string> around_at_start{};
  double length = 0;              ///< [m]
  std::optional<double> slide{};  ///< [m] along the body since the start, away from crown or trunk
  std::optional<double> twist{};  ///< [degrees] about it
};

struct PanelVerdict {
  std::string name;
  std::string part;               ///< of the body that most of it is nearest to
  std::optional<double> drift{};  ///< [m] as OpeningVerdict::slide
  std::optional<double> twist{};  ///< [degrees]
  double outward = 0;             ///< mean of the signs of its normals away from the body
  std::optional<double> outward_at_start{};
  std::optional<double> stretch{};  ///< largest; empty: no rest shape
  double stretched = 0;             ///< share of its area beyond WornLimits::stretch
};

/// A garment: a connected part of the cloth.
struct GarmentVerdict {
  std::string name;
  std::vector<OpeningVerdict> openings;
  std::vector<PanelVerdict> panels;
  std::optional<double> shoulders{};  ///< covered now over covered at the start
  std::vector<std::string> faults;    ///< a line each

  bool worn() const { return faults.empty(); }
};

struct WornInput {
  /// At the end, with panels as parts or groups. Where both are there, the names of groups may say
  /// which panels are in front.
  const Mesh& cloth;
  const Mesh& body;  ///< at the end
  /// The same at the start: as many vertices, else they are passed over. Null: not known
  const std::vector<Vec3<double>>* cloth_start = nullptr;
  const std::vector<Vec3<double>>* body_start = nullptr;  ///< null: as at the end
  Vec3<double> up{0, 0, 1};
  bool sewn = true;  ///< vertices at exactly one place are one
  const BodySegmentation& segmentation;
  WornLimits limits{};
};

/// An opening is tested by linking: a surface is spanned over each, and counts how often, with
/// sign, the centre lines of the body pass through. This does not depend on the surface, nor on
/// wrinkles. What panels are labelled as (sleeve, arm; leg, trouser) says what their openings
/// should be around, else what they were around at the start.
/// @return a verdict for each garment, in the order of their first vertices
std::vector<GarmentVerdict> worn(const WornInput& input);

}  // namespace weft::lab
