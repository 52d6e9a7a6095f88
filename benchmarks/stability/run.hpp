#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "benchmarks/stability/case.hpp"
#include "weft/simulation.hpp"

/// What the cases share: small scenes, jitter, a run that is watched, and what is asked at its end.
namespace weft::stability {

inline constexpr double side = 0.4;  ///< [m] of the sheets: L

/// A horizontal square sheet of `side`, of cells x cells quads, about (0, 0, z).
Cloth square(int cells, double z);

/// Light cotton with damping, 200 N/m.
Material cotton();

/// A scene of the setup's method, with gravity and one material, without cloths.
/// @param step [s] a frame a step
Scene empty_scene(const Setup& setup, double step);

/// Falls onto a sphere, in contact within a few steps.
Scene sheet_on_sphere(const Setup& setup, double step);

/// Vertical in the x-z plane, held along its upper edge.
Scene curtain(const Setup& setup, double step, int cells);

/// Vertices of a square that lie at x < -side / 2 + width, or x > side / 2 - width.
std::vector<Index> left_vertices(const Mesh& mesh, double width);
std::vector<Index> right_vertices(const Mesh& mesh, double width);

/// Moves all vertices of the cloths at random, by at most `share` of the mean edge a coordinate.
void jitter(Scene& scene, const Setup& setup, double share = 1e-3);

/// Asked of states that are checked, with the scene as it is then.
using Observer = std::function<void(const Scene&, const Frame&, const Energy&)>;

/// A simulation by whatever method. With "time_parallel", two threads work off slices of time, all
/// from the start of the scene, so that it can be watched only once and goes on from no checkpoint.
class Run {
 public:
  /// @param devices of a simulation; asked for again by each slice
  /// @throws SceneError, DeviceError as Simulation
  Run(Scene scene, std::function<DeviceSet()> devices);

  /// Does steps, and asks after them: is all finite, does the independent validator find no
  /// intersection (not looked for where self-contact is off)? After each of up to `judged` steps,
  /// spread evenly. With "time_parallel" from several threads, one at a time.
  /// @param folder of the slices: those that are done there already are taken over; empty: one that
  ///               is removed afterwards
  /// @throws SimulationError if a step is refused by name
  /// @throws Wrong if a state is not finite, or intersects
  void watch(int steps, int judged = usually_judged, const Observer& observer = {},
             const std::filesystem::path& folder = {});

  /// As it is now.
  const Simulation& now() const { return simulation_; }

  /// @throws SceneError as Simulation::resume(); with "time_parallel" always
  void resume(const std::filesystem::path& file, SceneChanges changes = SceneChanges::refuse);

 private:
  static constexpr int usually_judged = 60;
  void watch_slices(int steps, int every, const Observer& observer,
                    const std::filesystem::path& folder);

  Scene scene_;  ///< with "time_parallel" alone
  std::function<DeviceSet()> devices_;
  Simulation simulation_;
};

/// Run of a scene on the setup's device.
Run start(Scene scene, const Setup& setup);

/// start(), and so many steps.
Run run(Scene scene, const Setup& setup, int steps);

/// [J]
double total_energy(const Run& run);

/// [J] mass of all cloths times g times `side`: what energies are measured by
double weight_energy(const Scene& scene);

/// Energy comes from nowhere: at the end there is at most a hundredth of `scale` more than at the
/// start.
/// @throws Wrong if there is more
void require_no_energy_gain(double before, double after, double scale);

/// @throws Wrong with `what`, value and limit unless value <= limit
void require_at_most(double value, double limit, const std::string& what);

/// All cloths of a run as one mesh, as it is now.
Mesh cloth_mesh(const Run& run);

/// The largest distance between vertices of two meshes of the same cloths: those of the same
/// number, or at the same place of the material where the meshes differ. [m]
double largest_distance(const Mesh& a, const Mesh& b);

/// Runs `attempt`, which has to be refused.
/// @throws SceneError, DeviceError, SimulationError that it was refused with
/// @throws Wrong if it was not
template <class Attempt>
void must_be_refused(const Attempt& attempt, const std::string& what) {
  attempt();
  throw Wrong(what + " was accepted");
}

}  // namespace weft::stability
