// Cusick's drape test (ISO 9073-9): a disc of fabric hangs over the edge of a smaller one; how much
// of the ring around that its shadow covers.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <random>

#include "benchmarks/physics/sheets.hpp"
#include "benchmarks/physics/statics.hpp"
#include "benchmarks/physics/test.hpp"
#include "host/scene/fabric/fabrics.hpp"
#include "weft/error.hpp"

namespace weft::physics {
namespace {

constexpr double gravity = 9.81;   // [m/s^2]
constexpr double pedestal = 0.09;  // [m] radius
constexpr double specimen = 0.15;  // [m] radius

/// A fabric, and the drape coefficients that are published for its kind.
struct Kind {
  const char* name;
  const char* fabric;     ///< in the library (host/scene/fabric/fabrics.hpp); null: isotropic
  double density;         ///< [kg/m^2]
  double bending_length;  ///< [m] Peirce's cantilever
  double low, high;       ///< [%]
};

/// Cotton, with a third of polyester, and denim are measured fabrics of the library. Of silk no
/// public measurement has weight and stiffness of one piece: a sheet of a weight and a bending
/// length that are usual for crepe de chine.
constexpr Kind kinds[] = {
    {"silk", nullptr, 0.075, 0.012, 20, 40},
    {"cotton", "cotton_polyester", 0, 0, 60, 76},
    {"denim", "denim", 0, 0, 70, 90},
};

const Kind* find_kind(const std::string& name) {
  for (const Kind& k : kinds)
    if (name == k.name) return &k;
  return nullptr;
}

/// The ring between pedestal and rim with one more ring of cells within the pedestal, by which it
/// is clamped: a strip, x outwards, whose sides are joined.
Mesh make_ring(const Parameters& p, int cells) {
  const double around = std::numbers::pi * (pedestal + specimen);
  Mesh strip = make_sheet({specimen - pedestal, around, cells, 1, 0}, p);
  const double grain = 1e-6 * specimen;
  std::map<long long, Index> first_side;
  for (std::size_t v = 0; v < strip.material.size(); ++v)
    if (strip.material[v][1] < grain - around / 2)
      first_side[std::llround(strip.material[v][0] / grain)] = static_cast<Index>(v);
  Mesh ring;
  std::vector<Index> number(strip.material.size());
  for (const bool second : {false, true})
    for (std::size_t v = 0; v < strip.material.size(); ++v) {
      const auto& u = strip.material[v];
      if ((u[1] > around / 2 - grain) != second) continue;
      if (second) {
        const auto found = first_side.find(std::llround(u[0] / grain));
        if (found == first_side.end())
          throw SceneError("", "mesh", p.text("mesh"),
                           "a sheet with as many vertices on either side");
        number[v] = number[static_cast<std::size_t>(found->second)];
        continue;
      }
      number[v] = static_cast<Index>(ring.material.size());
      const double angle = 2 * std::numbers::pi * u[1] / around;
      ring.material.push_back(
          {(pedestal + u[0]) * std::cos(angle), (pedestal + u[0]) * std::sin(angle)});
    }
  for (const Tri& t : strip.triangles)
    ring.triangles.push_back(
        {{number[static_cast<std::size_t>(t.v[0])], number[static_cast<std::size_t>(t.v[1])],
          number[static_cast<std::size_t>(t.v[2])]}});
  return ring;
}

/// Starts it flat but for waves of all numbers of folds, the same for every mesh.
void perturb(Mesh& ring, double size, int seed) {
  constexpr int folds_min = 2;
  constexpr int folds_max = 12;
  std::mt19937_64 random(static_cast<std::uint64_t>(seed));
  std::vector<double> phases;
  for (int n = folds_min; n <= folds_max; ++n)
    phases.push_back(static_cast<double>(random() >> 11) * 0x1p-53 * 2 * std::numbers::pi);
  for (const auto& u : ring.material) {
    const double out = std::max(std::hypot(u[0], u[1]) - pedestal, 0.0) / (specimen - pedestal);
    double wave = 0;
    for (int n = folds_min; n <= folds_max; ++n)
      wave +=
          std::cos(n * std::atan2(u[1], u[0]) + phases[static_cast<std::size_t>(n - folds_min)]);
    ring.positions.push_back({u[0], u[1], size * out * out * wave});
  }
}

/// How far the shadow reaches in even directions about the middle. [m]
std::vector<double> shadow_radii(const Mesh& mesh, const std::vector<Vec3<double>>& x) {
  constexpr int directions = 720;
  std::vector<double> reach(directions, pedestal);
  for (const Tri& t : mesh.triangles)
    for (int j = 0; j < 3; ++j) {
      const auto& a = x[static_cast<std::size_t>(t.v[j])];
      const auto& b = x[static_cast<std::size_t>(t.v[(j + 1) % 3])];
      const double from = std::atan2(a[1], a[0]);
      const double turn = std::remainder(std::atan2(b[1], b[0]) - from, 2 * std::numbers::pi);
      const double unit = 2 * std::numbers::pi / directions;
      const auto first = static_cast<long>(std::ceil(std::min(from, from + turn) / unit));
      const auto last = static_cast<long>(std::floor(std::max(from, from + turn) / unit));
      for (long k = first; k <= last; ++k) {
        // Where the ray of direction k meets the edge.
        const double c = std::cos(static_cast<double>(k) * unit);
        const double s = std::sin(static_cast<double>(k) * unit);
        const double side_a = c * a[1] - s * a[0];
        const double side_b = c * b[1] - s * b[0];
        const double share = side_a == side_b ? 0 : side_a / (side_a - side_b);
        const double r = c * (a[0] + share * (b[0] - a[0])) + s * (a[1] + share * (b[1] - a[1]));
        auto& there = reach[static_cast<std::size_t>((k % directions + directions) % directions)];
        there = std::max(there, r);
      }
    }
  return reach;
}

/// Share of the ring that the shadow covers. [%]
double drape_coefficient(const std::vector<double>& reach) {
  double sum = 0;
  for (const double r : reach) sum += r * r;
  const double inner = pedestal * pedestal;
  return 100 * (sum / static_cast<double>(reach.size()) - inner) / (specimen * specimen - inner);
}

/// Maxima of the shadow's radius that stand out by a tenth of its range.
int count_folds(const std::vector<double>& reach) {
  const auto [low, high] = std::minmax_element(reach.begin(), reach.end());
  const double margin = 0.1 * (*high - *low);
  if (margin < 1e-3 * specimen) return 0;
  // Once around from the lowest place: up by the margin and down again is a fold.
  const auto begin = static_cast<std::size_t>(low - reach.begin());
  int folds = 0;
  bool rising = false;
  double extreme = *low;
  for (std::size_t k = 0; k <= reach.size(); ++k) {
    const double r = reach[(begin + k) % reach.size()];
    if (rising) {
      extreme = std::max(extreme, r);
      if (r < extreme - margin) {
        ++folds;
        rising = false;
        extreme = r;
      }
    } else {
      extreme = std::min(extreme, r);
      if (r > extreme + margin) {
        rising = true;
        extreme = r;
      }
    }
  }
  return folds;
}

struct Drape {
  double coefficient;  ///< [%]
  int folds;
  double energy;  ///< [J]
  double steps;
};

/// What to hang: a fabric of the library, or a sheet by its density and bending length.
Material material_of(const Parameters& p) {
  const std::string& name = p.text("fabric");
  const Kind* kind = find_kind(name);
  const Fabric* fabric =
      find_fabric(kind != nullptr && kind->fabric != nullptr ? kind->fabric : name);
  const bool own = p.number("bending_length") != 0;
  if (fabric != nullptr && !own) return fabric->material;
  if (kind == nullptr && fabric == nullptr && name != "none")
    throw SceneError("", "fabric", name,
                     "silk, cotton, denim, none, or one of 'weft info --fabrics'");
  const bool known = kind != nullptr && !own;
  Material material;
  material.density = known ? kind->density : p.positive("density");
  material.poisson_ratio = p.number("nu");
  material.stretch_stiffness = p.positive("stretch");
  // Peirce 1930: stiffness over weight is the cube of the bending length.
  material.bending_stiffness =
      material.density * gravity *
      std::pow(known ? kind->bending_length : p.positive("bending_length"), 3);
  if (const double shear = p.number("shear"); shear > 0)
    material.orthotropic = OrthotropicStretch{
        material.stretch_stiffness, material.stretch_stiffness, material.poisson_ratio, shear};
  return material;
}

/// A specimen at rest. Its weight grows in stages, as when the plate beneath it is lowered slowly:
/// let go at once it would keep the many small folds that grow fastest.
Drape hang(const Parameters& p, int cells) {
  Material material = material_of(p);
  material.damping_mass = p.number("damping");
  Mesh ring = make_ring(p, cells);
  perturb(ring, p.positive("perturbation"), p.count("start", 0));
  const auto held = vertices_where(
      ring, [](const Vec2<double>& u) { return std::hypot(u[0], u[1]) <= pedestal * (1 + 1e-9); });
  const double step = p.positive("step");
  Scene scene = make_scene(std::move(ring), material, step);
  scene.bending = bending_of(p);
  scene.solver.tolerance = 1e-3;
  scene.solver.newton_iterations = p.count("newton");
  scene.solver.newton_tolerance = 1e-3;
  pin(scene, held);
  const int stages = p.count("stages");
  Drape drape{};
  for (int stage = 1; stage <= stages; ++stage) {
    scene.gravity = {0, 0, -gravity * stage / stages};
    Simulation simulation = start(scene);
    advance(simulation, static_cast<int>(p.positive("time") / step));
    if (stage == stages) settle(simulation, p.positive("rest") * step, 3000);
    scene.cloths[0].mesh.positions = positions(simulation);
    const Energy energy = simulation.energy();
    drape.energy = energy.elastic + energy.gravitational;
    drape.steps += static_cast<double>(simulation.step_number());
  }
  const auto reach = shadow_radii(scene.cloths[0].mesh, scene.cloths[0].mesh.positions);
  drape.coefficient = drape_coefficient(reach);
  drape.folds = count_folds(reach);
  return drape;
}

/// Drape coefficient [%] of a fabric, against the middle of the band that is published.
Outcome cusick_drape(const Parameters& p) {
  const Drape drape = hang(p, p.count("cells"));
  const Kind* kind = p.number("bending_length") == 0 ? find_kind(p.text("fabric")) : nullptr;
  Outcome outcome = kind == nullptr ? unjudged(drape.coefficient)
                                    : absolute(drape.coefficient, (kind->low + kind->high) / 2,
                                               (kind->high - kind->low) / 2);
  outcome.more = {{"folds", drape.folds}, {"energy", drape.energy}, {"steps", drape.steps}};
  return outcome;
}

/// Change of the drape coefficient with cells of two thirds of the size. [points]
Outcome cusick_refinement(const Parameters& p) {
  const int cells = p.count("cells");
  const Drape coarse = hang(p, cells);
  const Drape fine = hang(p, (3 * cells + 1) / 2);
  Outcome outcome = absolute(std::abs(fine.coefficient - coarse.coefficient), 0, 2);
  outcome.more = {{"coarse", coarse.coefficient},
                  {"fine", fine.coefficient},
                  {"folds_coarse", coarse.folds},
                  {"folds_fine", fine.folds}};
  return outcome;
}

}  // namespace

std::vector<Test> drape_tests() {
  const auto parameters =
      std::vector<Parameter>{{"fabric", "cotton", "silk, cotton, denim, or of the library"},
                             {"bending_length", "0", "[m]; 0: the fabric's"},
                             {"density", "0.2", "[kg/m^2] with a bending length"},
                             {"cells", "8", "from the pedestal to the rim"},
                             {"stretch", "1000", "[N/m] Young's modulus times thickness"},
                             {"shear", "50", "[N/m] shear modulus times thickness; 0: isotropic"},
                             {"nu", "0.2", "Poisson's ratio"},
                             {"perturbation", "1e-4", "[m] amplitude of each wave at the start"},
                             {"start", "1", "seed of their phases"},
                             {"stages", "8", "in which the weight grows"},
                             {"damping", "5", "[1/s] of mass"},
                             {"time", "0.3", "[s] of each stage"},
                             {"rest", "2e-3", "[m/s] largest speed at rest"},
                             {"step", "0.01", "[s]"},
                             {"newton", "1", "iterations a step"}} +
      bending_parameter() + mesh_parameters();
  return {{"cusick_drape", "drape coefficient in per cent; the middle of the published band",
           parameters, cusick_drape},
          {"cusick_refinement", "its change in points when cells shrink to two thirds; 0",
           parameters, cusick_refinement}};
}

}  // namespace weft::physics
