#pragma once

#include <random>
#include <string>
#include <vector>

#include "weft/scene.hpp"

/// Bodies and garments made of capsules, for tests of what is worn.
namespace weft::lab::test {

using Rng = std::mt19937;
double between(Rng& rng, double low, double high);

/// A cone with round ends.
struct Capsule {
  std::string name;
  Vec3<double> a, b;
  double ra, rb;
};

struct BodyShape {
  double arm = 0.8;      ///< [rad] of the arms from straight down
  double spread = 0.14;  ///< [m] of the feet
  double girth = 1;
  double scale = 1;
};
BodyShape any_shape(Rng& rng);
std::vector<Capsule> capsules_of(const BodyShape& shape);

/// Surface of the union of capsules, by marching tetrahedra.
Mesh surface_of(const std::vector<Capsule>& capsules, double cell);

enum class GarmentKind { shirt, vest, trousers, skirt, dress, strapless };
inline constexpr int garment_kinds = 6;

/// A garment on its body, and where it started.
struct Dressed {
  Mesh cloth, body;
  std::vector<Vec3<double>> cloth_start, body_start;
  bool with_start = true;
  std::vector<std::string> capsule;  ///< [vertices of cloth] the nearest one's name
  BodyShape shape;
  GarmentKind kind = GarmentKind::shirt;
};

/// @param labelled panels are sleeves and the like, else there is one group
Dressed dress(GarmentKind kind, const BodyShape& shape, bool labelled, Rng& rng);

/// A good fit of any kind.
Dressed good_fit(int number, Rng& rng);

inline constexpr int fault_kinds = 12;
/// @return what is wrong with it, for messages
std::string plant_fault(int number, Dressed& d, Rng& rng);
/// A bad fit, with a fault of the number's kind.
Dressed bad_fit(int number, Rng& rng, std::string& what);

}  // namespace weft::lab::test
