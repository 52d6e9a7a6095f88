#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "weft/core/ids.hpp"
#include "weft/core/vec.hpp"

/// A scene as the simulation takes it: every file read, every default filled in. SI units, z up.
/// weft::io reads scenes from JSON; a program that embeds weft may fill the structs itself.
namespace weft {

/// Triangle mesh. Corners are counter-clockwise seen from the front.
struct Mesh {
  std::vector<Vec3<double>> positions;  ///< [m] world space
  std::vector<Vec2<double>> material;   ///< [m] material coordinates a vertex; empty: none
  std::vector<Tri> triangles;
};

/// Rigid placement: x -> rotate(scale * x) + translate.
struct Transform {
  Vec3<double> translate{0, 0, 0};      ///< [m]
  Vec3<double> rotation_axis{0, 0, 1};  ///< unit
  double rotation_angle = 0;            ///< [rad]
  double scale = 1;
};

/// Placement at one instant. A motion is a list of these in increasing time, at least two;
/// between keys the placement is interpolated (cubic Hermite, Catmull-Rom slopes, zero slope at
/// both ends), outside it is held.
struct Keyframe {
  double time = 0;  ///< [s]
  Transform transform;
};
using Motion = std::vector<Keyframe>;

/// Isotropic thin sheet.
struct Material {
  std::string name;
  double density = 0.2;             ///< [kg/m^2] mass per area, > 0
  double stretch_stiffness = 1000;  ///< [N/m] Young's modulus times thickness, > 0
  double poisson_ratio = 0.3;       ///< (-1, 0.5]
  double bending_stiffness = 1e-5;  ///< [N m] plate stiffness, >= 0
  double damping_mass = 0;          ///< [1/s] Rayleigh, force -a M v, >= 0
  double damping_stiffness = 0;     ///< [s] Rayleigh, force -b K v, >= 0
};

struct Cloth {
  std::string name;
  Mesh mesh;           ///< initial world positions; material coordinates set the rest shape
  Index material = 0;  ///< into Scene::materials
  Vec3<double> velocity{0, 0, 0};  ///< [m/s] initial
};

/// Surface with prescribed motion and infinite mass. Self-contact of obstacles is ignored.
struct Obstacle {
  std::string name;
  Mesh mesh;              ///< before `transform`
  Transform transform;    ///< where it stands if there is no motion
  Motion motion;          ///< replaces `transform`; empty: static
  double friction = 0.3;  ///< Coulomb coefficient against cloth, >= 0
};

/// Vertices held in place, or carried along by a motion (applied to their initial positions).
struct Pin {
  Index cloth = 0;              ///< into Scene::cloths
  std::vector<Index> vertices;  ///< numbers within that cloth, in input order
  Motion motion;                ///< empty: held where they start
  double release_time = std::numeric_limits<double>::infinity();  ///< [s]
};

struct ContactSettings {
  bool self = true;         ///< cloth against cloth, itself included
  double thickness = 1e-3;  ///< [m] distance at which repulsion starts, > 0
  double friction = 0.3;    ///< Coulomb coefficient, cloth against cloth, >= 0
  double stiffness = 10;    ///< repulsion in units of pair mass / time_step^2, > 0
  int zone_rounds = 60;     ///< rounds of CCD and impact zones a step before it is retried
  int halvings = 5;         ///< how often a failing step may be halved
};

enum class Integrator { implicit_euler, bdf2 };
enum class Precision { single_precision, double_precision };

struct SolverSettings {
  double tolerance = 1e-3;    ///< true residual over right-hand side, 2-norm, (0, 1)
  int max_iterations = 2000;  ///< a linear solve, >= 1
  int newton_iterations = 1;  ///< 1: linearly implicit, equation (3) of P-Cloth
  double newton_tolerance =
      1e-6;  ///< stops earlier once the non-linear residual is below this share of the first
  bool line_search = true;  ///< for newton_iterations > 1; not there yet, must be false then
  int partial_rows =
      0;  ///< rows per partial sum of a dot product, a power of two; 0: from the row count
};

struct TimeSettings {
  double step = 0.005;  ///< [s] > 0
  double frame_rate =
      25;           ///< [1/s] > 0; steps a frame are rounded up so that frames are hit exactly
  int frames = 50;  ///< >= 1
};

enum class FrameFormat { obj, ply };

struct OutputSettings {
  FrameFormat format = FrameFormat::obj;
  int checkpoint_every = 5;  ///< frames; 0: only at the end and on failure
};

struct Scene {
  std::string name;
  std::string file;                   ///< where it was read, for messages; may be empty
  Vec3<double> gravity{0, 0, -9.81};  ///< [m/s^2]
  TimeSettings time;
  std::vector<Material> materials;
  std::vector<Cloth> cloths;
  std::vector<Obstacle> obstacles;
  std::vector<Pin> pins;
  ContactSettings contact;
  SolverSettings solver;
  OutputSettings output;
  std::string method = "implicit";
  Integrator integrator = Integrator::implicit_euler;
  Precision precision = Precision::single_precision;
};

/// Placement at `time`, see Keyframe.
/// @pre motion has at least two keys in increasing time
Transform transform_at(const Motion& motion, double time);

/// rotate(scale * x) + translate
Vec3<double> apply(const Transform& transform, const Vec3<double>& x);

/// Checks everything that can be checked without simulating: ranges, finiteness, references between
/// parts, mesh topology (index range, degenerate and non-manifold parts).
/// @throws SceneError with file, field, value and what is allowed
void validate(const Scene& scene);

}  // namespace weft
