#pragma once

#include <cstdint>
#include <vector>

#include "host/implicit/zone_list.hpp"
#include "weft/core/vec.hpp"
#include "weft/devices.hpp"
#include "weft/kernels/respond/zones.hpp"

namespace weft::test {

/// Vertices that move in a step, and what they run into.
struct ZoneCase {
  std::vector<Vec3<double>> start, end;  ///< [vertices] [m]
  std::vector<double> mass;              ///< [vertices] [kg] of prescribed ones: not in use
  std::vector<unsigned char> fixed;      ///< [vertices]
  std::vector<unsigned char> yielding;   ///< [vertices]
  std::vector<Collision> collisions;

  Index add(const Vec3<double>& from, const Vec3<double>& to, double m, bool held = false);
};

struct ZoneResult {
  std::vector<MovedVertex<double>> moved;  ///< by vertex
  std::vector<Vec3<double>> end;           ///< [vertices] [m] with them
  std::vector<ZoneOutcome> outcomes;
  int passes = 0;
  bool solved = true;  ///< every zone
};

/// Joins the zones of a case, shares them out to `ranks` and runs the kernel on each share.
/// @param first_new as ZoneList takes it
ZoneResult solve_zones(const ZoneCase& zones, ZoneMotion motion = ZoneMotion::impacts,
                       int ranks = 1, std::size_t first_new = 0);

/// Numbers that are the same everywhere for a seed.
class ZoneRandom {
 public:
  explicit ZoneRandom(std::uint64_t seed) : state_(seed) {}
  double uniform(double low, double high);
  Vec3<double> vector(double size);
  std::size_t below(std::size_t n);

 private:
  std::uint64_t state_;
};

/// Impact of a vertex and a triangle, or of two edges, that continuous detection finds in a random
/// motion: the offset is what the step takes.
/// @param kind 1: vertex and triangle, 2: two edges
/// @param mass_ratio masses are spread over 1 to this, evenly in the logarithm
ZoneCase random_impact(ZoneRandom& random, int kind, double mass_ratio);

/// Sum of m u.
Vec3<double> momentum(const ZoneCase& zones, const std::vector<Vec3<double>>& end);
/// Sum of m |u|.
double momentum_size(const ZoneCase& zones, const std::vector<Vec3<double>>& end);
/// Sum of m |u|^2 / 2, per step length squared.
double kinetic(const ZoneCase& zones, const std::vector<Vec3<double>>& end);
/// Gap along the normal.
double gap(const Collision& c, const std::vector<Vec3<double>>& x);
/// Largest share of its offset that a collision is short of.
double worst_share(const ZoneCase& zones, const std::vector<Vec3<double>>& end);

}  // namespace weft::test
