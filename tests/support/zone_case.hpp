#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "host/implicit/collision_response/zone_list.hpp"
#include "weft/core/vec.hpp"
#include "weft/devices.hpp"
#include "weft/kernels/respond/zones.hpp"

namespace weft::test {

/// Vertices that move in a step, and what they run into.
struct ZoneCase {
  std::vector<Vec3<double>> start, end;  ///< [vertices] [m]
  std::vector<double> mass;              ///< [vertices] [kg] of prescribed ones: not in use
  std::vector<unsigned char> fixed;      ///< [vertices]
  std::vector<unsigned char> compliant;  ///< [vertices]
  std::vector<Collision> collisions;
  std::size_t obstacle_vertices = 0;  ///< the last so many, which are fixed

  Index add(const Vec3<double>& from, const Vec3<double>& to, double m, bool held = false);
  /// Appends another case.
  /// @pre    no obstacles
  /// @return the number of its first vertex
  Index add(const ZoneCase& other);
};

struct ZoneResult {
  std::vector<MovedVertex<double>> moved;  ///< by vertex
  std::vector<Vec3<double>> end;           ///< [vertices] [m] with them
  std::vector<ZoneOutcome> outcomes;
  int passes = 0;           ///< of all rounds
  int passes_of_round = 0;  ///< of the longest
  int rounds = 0;
  bool solved = true;  ///< every zone
};

/// Solves zones on a device, as launch() does.
template <class T>
using ZoneRun = std::function<void(Queue&, const RespondZones<T>&)>;

/// Joins collisions of a case into zones.
/// @param count     the first so many of its collisions
/// @param first_new as ZoneList::join() takes it, as are the others
void join(ZoneList& list, const ZoneCase& zones, std::size_t count, std::size_t first_new,
          bool all = false, int ranks = 1);

/// Solves the zones that a list has joined, share by share, and lets it keep the multipliers.
template <class T>
ZoneResult solve_listed_with(Device& device, const ZoneRun<T>& run, const ZoneCase& zones,
                             ZoneList& list, ZoneMotion motion = ZoneMotion::impacts);

/// Joins the zones of a case, shares them out to `ranks` and solves each share.
/// @param rounds_max until all are solved, each from what the one before has left
template <class T>
ZoneResult solve_zones_with(Device& device, const ZoneRun<T>& run, const ZoneCase& zones,
                            ZoneMotion motion, int ranks = 1, int rounds_max = 1);

/// Two rounds, the second of which finds all collisions but the first `old`.
/// @return what the second comes to
template <class T>
ZoneResult solve_warm_with(Device& device, const ZoneRun<T>& run, const ZoneCase& zones,
                           std::size_t old, int ranks = 1);

/// The same by the kernel, on the host, in double.
ZoneResult solve_listed(const ZoneCase& zones, ZoneList& list,
                        ZoneMotion motion = ZoneMotion::impacts);
ZoneResult solve_zones(const ZoneCase& zones, ZoneMotion motion = ZoneMotion::impacts,
                       int ranks = 1, int rounds_max = 1);
ZoneResult solve_warm(const ZoneCase& zones, std::size_t old, int ranks = 1);

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

/// Random motion of `count` vertices, and `impacts` constraints between them that hold at the start
/// and are broken at the end.
ZoneCase tangle(ZoneRandom& random, std::size_t count, std::size_t impacts, double mass_ratio);

/// Two held vertices close on a free one, until at 0.9 no place is left.
ZoneCase vice(double closing);

/// `count` layers, each of which has been pushed through the one below, with a wall under the
/// first. A push from below has to go through all of them.
/// @param mass_ratio between one layer and the next
/// @param redundant  with constraints that hardly differ
ZoneCase chain(std::size_t count, double mass_ratio, bool redundant);

/// Adds a collision that no end meets together with the first one.
void exclude_the_first(ZoneCase& zones);

/// A sheet of `side` x `side` vertices that has been pushed through one below it: a collision for
/// each vertex of the upper one, with masses of 1 to 2. One zone.
/// @param obstacle the lower sheet is an obstacle, which rises, and whose vertices collide
ZoneCase sheets(ZoneRandom& random, Index side, bool obstacle);

/// Appends a case, the last collision of which is there again with one vertex that is held.
void add_held(ZoneCase& all, const ZoneCase& one, Index held);

/// Intersections of 12 vertices from number 1 on, which share the first vertex, that is held, and
/// so are a zone or more each.
ZoneCase tangles(ZoneRandom& random, int count);

/// Sum of m u.
Vec3<double> momentum(const ZoneCase& zones, const std::vector<Vec3<double>>& end);
/// Sum of m |u|.
double momentum_size(const ZoneCase& zones, const std::vector<Vec3<double>>& end);
/// Sum of m |u|^2 / 2, per step length squared.
double kinetic(const ZoneCase& zones, const std::vector<Vec3<double>>& end);
/// Gap along the normal.
double gap(const Collision& c, const std::vector<Vec3<double>>& x);
/// Whether every collision has its offset at the start.
bool start_satisfies(const ZoneCase& zones);
/// The same bits for the same vertices.
bool same_bits(const ZoneResult& a, const ZoneResult& b);
/// Largest share of its offset that a collision is short of.
double worst_share(const ZoneCase& zones, const std::vector<Vec3<double>>& end);

}  // namespace weft::test
