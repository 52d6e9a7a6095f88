#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "weft/devices.hpp"
#include "weft/frame.hpp"
#include "weft/report.hpp"
#include "weft/scene.hpp"

namespace weft {

struct Tracking;

/// Whether a checkpoint may come from a scene that differs.
enum class SceneChanges { refuse, allow };

/// A running scene. Same scene, same kind of devices: same bits, for any number of devices.
/// Not for use by several threads at once.
class Simulation {
 public:
  /// @throws SceneError  if the scene is not valid, or starts intersecting or inside an obstacle
  /// @throws StoppedError if the devices are told to stop meanwhile
  /// @throws DeviceError if the devices cannot carry it
  Simulation(Scene scene, DeviceSet devices);
  ~Simulation();
  Simulation(Simulation&&) noexcept;
  Simulation& operator=(Simulation&&) noexcept;

  /// The scene as it is now. Refinement and remeshing replace the cloths' meshes, and renumber the
  /// vertices of pins, handles and seams.
  const Scene& scene() const;

  /// Does one time step; at the end of a frame also welds what seams have brought together. If
  /// report.failure is not none the state is that of the start of the step, and stays valid.
  /// @throws DeviceError if a device is lost or out of memory
  StepReport step();

  /// Steps that one frame takes: the scene's time step, rounded so that frames are hit exactly.
  int steps_per_frame() const;
  /// [s] length of a step
  double step_length() const;

  std::int64_t step_number() const;
  double time() const;       ///< [s]
  int frame_number() const;  ///< frames completed
  Frame frame() const;
  Energy energy() const;

  /// FNV-1a, 64 bits, over topology, positions and velocities in input order at run precision.
  std::uint64_t state_hash() const;

  /// How the ranks of linear solves reach each other: peer or pipelined. The method asynchronous
  /// has none.
  Transport transport() const;

  /// [bytes] most that each rank has held
  std::vector<std::size_t> peak_device_bytes() const;
  /// Of each rank, by what the memory is for
  std::vector<std::vector<MemoryUse>> device_memory() const;

  /// From now on, steps of the method "implicit" keep averages over parts of the cloth where
  /// `tracking` says, until seams are welded or meshes change. Null: no tracking.
  /// @throws DeviceError unless all is on one rank of the host
  void track(std::shared_ptr<const Tracking> tracking);

  /// Writes a checkpoint to a temporary file beside `file`, syncs it and renames it.
  /// @param synced false: does not wait for the disk. The file then survives the end of the
  ///               program, but a power cut may damage it
  /// @throws std::filesystem::filesystem_error if that fails; `file` is then as it was
  void save(const std::filesystem::path& file, bool synced = true) const;

  /// Takes the state over from a checkpoint of the same scene; later steps give the same bits as if
  /// the run had never stopped. Output, devices, camera and number of frames may differ.
  /// @param changes what to do if the scene differs in anything else, such as a pin, a material or
  ///                the step
  /// @return        one line for each part that differs: its name, then and now
  /// @throws SceneError if the file is damaged, truncated, of another version, of other meshes, or
  ///         of a scene whose changes are refused
  std::vector<std::string> resume(const std::filesystem::path& file,
                                  SceneChanges changes = SceneChanges::refuse);

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace weft
