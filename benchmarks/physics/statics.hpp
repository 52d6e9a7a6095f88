#pragma once

#include <string>
#include <vector>

#include "benchmarks/physics/test.hpp"
#include "weft/scene.hpp"
#include "weft/simulation.hpp"

namespace weft::physics {

/// A scene without gravity and contact, of one cloth and one undamped material, with a solver that
/// takes each step to rounding.
/// @param step [s]
Scene make_scene(Mesh mesh, const Material& material, double step);

Simulation start(Scene scene);

/// The key `bending`, and what it names.
/// @throws SceneError unless it is plate or hinge
std::vector<Parameter> bending_parameter();
Bending bending_of(const Parameters& parameters);

/// Does steps until `time` has passed.
/// @throws SimulationError if one fails
void advance(Simulation& simulation, int steps);

/// Does steps until no vertex moves by more than `tolerance` [m] in one: implicit Euler with a step
/// far above the slowest period is Newton's method on the equilibrium.
/// @throws SimulationError if a step fails, or `steps_max` do not suffice
void settle(Simulation& simulation, double tolerance, int steps_max);

/// Holds vertices where they are.
void pin(Scene& scene, std::vector<Index> vertices);

/// A force that never changes, on each of the vertices: the spring of a handle that is so far away
/// and so soft that no motion of the cloth makes a difference.
/// @param force   [N] on a vertex of weight 1
/// @param weights [vertices]
/// @param reach   [m] size of the scene
void add_dead_load(Scene& scene, const std::vector<Index>& vertices,
                   const std::vector<double>& weights, const Vec3<double>& force, double reach);

/// Shares of a load that is even along a line: lengths of line that belong to each vertex, over the
/// whole length. The line runs along y.
std::vector<double> line_shares(const Mesh& mesh, const std::vector<Index>& vertices);

/// Positions of the only cloth. [m]
std::vector<Vec3<double>> positions(const Simulation& simulation);

/// Mean place of some vertices. [m]
Vec3<double> mean_place(const Simulation& simulation, const std::vector<Index>& vertices);

/// Settings for small vibrations.
struct Vibration {
  Vec3<double> direction{0, 0, 1};  ///< unit; the motion of all vertices
  double amplitude = 1e-6;          ///< [m] small enough for linear forces
  double step = 1;                  ///< [s] about the period of the slowest mode
  int modes = 1;                    ///< wanted
  int rounds = 12;
};

/// Squares of the lowest angular frequencies of small vibrations about where the scene's cloth is,
/// in ascending order; negative where it is unstable. A step of implicit Euler from a displacement
/// u, at rest, ends at (M + h^2 K)^-1 M u; subspace iteration on that, starting from polynomials.
/// Measures the engine's own mass and stiffness, without any error of time stepping.
/// @pre the cloth is in equilibrium but for forces across `direction`
/// @return [1/s^2], `modes` of them
std::vector<double> vibration_squares(const Scene& scene, const Vibration& vibration);

/// A column of a reference table in the folder that WEFT_TEST_DATA names, interpolated linearly in
/// the logarithm of the first column where that is not a row.
/// @throws SceneError if the environment names no folder, or the table lacks what is asked for
double table_value(const std::string& file, const std::string& column, double first);

/// Whether WEFT_TEST_DATA is set.
bool has_tables();

}  // namespace weft::physics
