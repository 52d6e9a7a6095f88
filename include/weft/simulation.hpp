#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "weft/advance.hpp"
#include "weft/device_positions.hpp"
#include "weft/devices.hpp"
#include "weft/frame.hpp"
#include "weft/handle_state.hpp"
#include "weft/report.hpp"
#include "weft/rest_state.hpp"
#include "weft/scene.hpp"
#include "weft/seam_state.hpp"
#include "weft/step_progress.hpp"

namespace weft {

/// Whether a checkpoint may come from a different scene.
enum class SceneChanges { refuse, allow };

/// A running scene. The same scene on the same kind of device gives the same bits, for any number
/// of devices. Not thread-safe, but for progress(): a call while another thread is in one throws
/// std::logic_error.
class Simulation {
 public:
  /// @throws SceneError  if the scene is not valid, or starts intersecting or inside an obstacle
  /// @throws StoppedError if the devices are told to stop during setup
  /// @throws DeviceError if the devices cannot run the scene, or have been moved into another one
  Simulation(Scene scene, DeviceSet devices);
  Simulation(Scene scene, AutoDevice);
  ~Simulation();
  Simulation(Simulation&&) noexcept;
  Simulation& operator=(Simulation&&) noexcept;

  /// The scene as it is now. Refinement and remeshing replace the cloths' meshes, and renumber the
  /// vertices of pins, handles and seams. Its positions are relative to origin().
  const Scene& scene() const;

  /// [m] world place that the state is relative to. (0, 0, 0) unless the cloth starts farther from
  /// there than four times its size. It stays as it is for the whole run.
  Vec3<double> origin() const;

  /// Does one time step. At the end of every second step and of every frame, it also welds seam
  /// pairs that are close enough. If
  /// report.failure is not `none`, the state is still that of the start of the step.
  /// @throws DeviceError if a device is lost or out of memory, std::bad_alloc if the host is:
  ///         restore() or resume() has to follow
  StepReport step();

  /// Takes the steps of one frame, whose length the program chooses. What it has moved arrives at
  /// its targets at the end of the frame, on straight lines. If a budget, a stop or a failure
  /// interrupts a frame, the next call goes on with it, whatever `seconds` that call asks for;
  /// targets set in between are those of the frame after it. So the states are the same, bit for
  /// bit, for any budget. A frame whose targets cannot be reached is given up by restore() with a
  /// state() from before they were set.
  /// @param seconds at least 1e-9. A whole number of the scene's steps takes these; any other
  ///                time takes steps of one length, no longer than the scene's.
  ///                With automatic steps: a whole number of
  ///                the scene's frames
  /// @throws SceneError if it is out of range
  /// @throws DeviceError as step()
  AdvanceResult advance(double seconds, const AdvanceOptions& options = {});

  /// Where the vertices of a live obstacle, or of a pin without a motion and without an obstacle,
  /// are to be at the end of the next frame of advance(). They stay there until they are moved
  /// again. Steps outside of advance() do not move them.
  /// @param places [vertices] [m] world places, a pin's in the order of Pin::vertices
  /// @throws SceneError if the part is of another scene or cannot be moved, if there are more or
  ///         fewer places than vertices, or if one is not finite or too far away
  void move(ObstacleId obstacle, std::span<const Vec3<double>> places);
  void move(PinId pin, std::span<const Vec3<double>> places);
  /// Lets the vertices of a pin go, from now on.
  void release(PinId pin);
  /// From now on. @throws SceneError if a value is out of range
  void set_gravity(const Vec3<double>& gravity);  ///< [m/s^2]
  void set_wind(const Wind& wind);
  /// Constant forces on the vertices of a cloth, from now on, beside all others. Where vertices are
  /// sewn to one, theirs add up; on pinned vertices they do nothing.
  /// @param forces [vertices] [N] in input order; empty: none
  /// @throws SceneError if the cloth is of another scene, if there are more or fewer forces than
  ///         vertices, if one is not finite or too large, or if the scene remeshes, has `refine` or
  ///         a `sleep_distance`, or is of the method asynchronous
  void set_forces(ClothId cloth, std::span<const Vec3<double>> forces);

  /// [vertices] [m] Positions of a cloth in input order, in world places. They are the simulation's
  /// own, valid until the next call of anything but const functions, or of this one for the same
  /// cloth. One copy from the device, and no allocation after the first call.
  /// @throws SceneError if the cloth is of another scene
  std::span<const Vec3<float>> positions(ClothId cloth);

  /// The same where the simulation runs: without a copy to the host, and without waiting. The
  /// memory is the simulation's own, and valid until the next call of anything but const functions.
  /// @param stream cudaStream_t of the program on that GPU, null: CUDA's default stream. Work that
  ///               it is given after this call finds the positions. What it still has to do when
  ///               the next call comes is done before that call overwrites them. On the host, which
  ///               ignores it, they are there when this function returns
  /// @throws SceneError if the cloth is of another scene
  DevicePositions device_positions(ClothId cloth, void* stream = nullptr);

  /// How far step() is. This is the one function that another thread may call while step() runs,
  /// as often as it likes, and any number of threads may: it waits for nothing and changes no
  /// result. The step publishes its figures one by one, so they may be some microseconds apart.
  /// They stand still during a single linear solve and a single round of impact zones.
  /// @return the default value if no step is under way
  StepProgress progress() const noexcept;

  /// Number of steps per frame. The scene's time step is shortened so that frames are hit exactly.
  /// 0 if steps are of automatic length, see TimeSettings::automatic.
  int steps_per_frame() const;
  /// [s] length of a step. If it is automatic, that of the next one, which a step that turns out to
  /// be too long falls short of.
  double step_length() const;

  std::int64_t step_number() const;
  double time() const;  ///< [s]
  /// Frames of the scene's frame rate completed, however long the frames of advance() are.
  int frame_number() const;
  bool at_frame_end() const;  ///< whether the state is that of a frame
  Frame frame() const;        ///< in world positions
  /// The frame relative to origin(): exactly the numbers of the state. World positions far from
  /// (0, 0, 0) round them to double precision there.
  Frame local_frame() const;
  Energy energy() const;  ///< with the gravitational energy relative to origin()
  /// Whether the cloth rests, as of the last frame of the scene's frame rate. Counted only where
  /// TimeSettings::until is RunUntil::rest; elsewhere nothing ever rests. Decided by positions and
  /// velocities alone: the same on any number of devices, and after resume().
  RestState rest() const;
  /// How far each seam has been sewn, in the order of the scene as it was given.
  std::vector<SeamState> seams() const;
  /// What each handle of the scene does to its cloth now, in the order of Scene::handles.
  std::vector<HandleState> handles() const;

  /// FNV-1a, 64 bits, at run precision, over topology, positions and velocities in input order, the
  /// contact cache, and the state of driven obstacles. Positions are relative to origin(), which is
  /// not part of it.
  std::uint64_t state_hash() const;

  /// Transport of the linear solves: peer or pipelined. It has no meaning with the method
  /// asynchronous, which has no linear solves.
  Transport transport() const;

  /// [bytes] peak memory of each rank
  std::vector<std::size_t> peak_device_bytes() const;
  /// Memory of each rank, by purpose
  std::vector<std::vector<MemoryUse>> device_memory() const;

  /// Writes a checkpoint to a temporary file beside `file`, syncs it and renames it.
  /// @param synced false: does not wait for the disk. The file then survives the end of the
  ///               program, but a power cut may damage it
  /// @throws SceneError if that fails; `file` is then unchanged
  void save(const std::filesystem::path& file, bool synced = true) const;

  /// Loads the state from a checkpoint of the same scene. Later steps give the same bits as if the
  /// run had never stopped. Output, devices, camera and number of frames may differ.
  /// @param changes what to do if the scene differs in anything else, such as a pin, a material or
  ///                the step
  /// @return        one line per part that differs: its name, its old and its new value
  /// @throws SceneError if the file is damaged, truncated, of another version, of other meshes, or
  ///         of a scene whose changes are refused
  std::vector<std::string> resume(const std::filesystem::path& file,
                                  SceneChanges changes = SceneChanges::refuse);

  /// What save() would write, in memory.
  std::string state() const;
  /// As resume() from what state() or a file of save() holds.
  std::vector<std::string> restore(const std::string& state,
                                   SceneChanges changes = SceneChanges::refuse);

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace weft
