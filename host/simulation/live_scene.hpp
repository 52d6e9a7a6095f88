#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/simulation/frame_clock.hpp"
#include "host/simulation/live_inputs.hpp"
#include "host/simulation/remeshing.hpp"
#include "host/simulation/rest_count.hpp"
#include "host/simulation/run.hpp"
#include "host/simulation/sew.hpp"
#include "host/state/checkpoint.hpp"
#include "weft/devices.hpp"
#include "weft/handle_state.hpp"
#include "weft/report.hpp"
#include "weft/seam_state.hpp"

namespace weft {

/// A scene as it stands now, after the program's inputs, welding, refinement and remeshing, and the
/// run of it.
class LiveScene {
 public:
  /// @param devices must outlive this
  /// @throws SceneError if the scene is not valid, or starts with intersections; DeviceError if the
  ///         devices cannot run its method; StoppedError if the devices are stopped
  LiveScene(Scene scene, DeviceSet& devices);
  LiveScene(const LiveScene&) = delete;  // the run refers to the scene
  LiveScene& operator=(const LiveScene&) = delete;

  const Scene& scene() const { return scene_; }
  FrameClock& clock() { return clock_; }

  /// @param use called with the Run of the scene's precision
  template <class Use>
  auto visit(Use use) {
    return visit_current([&](auto& current) { return use(*current); });
  }
  double time();
  std::int64_t step_number();
  bool at_frame_end();
  /// [s] of the next step
  double step_length();
  int frame_number();
  Energy energy();
  std::vector<SeamState> seams();
  std::vector<HandleState> handles();

  /// Welds the pairs of seams that are close enough, and refines once all of them are welded.
  /// Not only at the end of a frame: pairs that have met and go on pulling for long fold the cloth
  /// beside them in between.
  /// @param report of the step that ends, counts the searches for collisions
  /// @return [J] change of the cloth's energy
  /// @throws StoppedError if the devices are stopped, half done: see may_stop_sewing()
  double sew(bool frame_ends, StepReport& report);
  /// Whether the devices may be stopped while sew() works at the end of the next step.
  bool may_stop_sewing();
  /// Goes back to a checkpoint() from before a step.
  void undo_step(const std::string& checkpoint);
  /// Brings the meshes of an adaptive method to what their state asks for.
  RemeshReport remesh();
  /// Of the present state; empty if no material has strain limits.
  std::optional<double> limit_excess();
  std::int64_t open_seam_pairs() const;
  const RestState& rest() const { return rest_.state(); }
  /// Counts a frame that has ended.
  void count_rest();

  void begin_program_frame(double seconds);
  void move(ObstacleId obstacle, Span<const Vec3<double>> places);
  void move(PinId pin, Span<const Vec3<double>> places);
  void release(PinId pin);
  void set_gravity(const Vec3<double>& gravity);
  void set_forces(ClothId cloth, Span<const Vec3<double>> forces);
  void set_wind(const Wind& wind);

  /// All that a checkpoint holds.
  std::string checkpoint();
  /// How the scene that a checkpoint comes from differs from this one, see Simulation::resume().
  std::vector<std::string> differences(const CheckpointReader& in) const;
  /// Takes up the run that a checkpoint comes from.
  /// @param same_scene its count of quiet frames goes on, see RestState
  /// @throws SceneError if it does not fit: nothing has changed
  void resume(const CheckpointReader& in, bool same_scene);

 private:
  /// @param use called with the pointer to that Run, which it may replace
  template <class Use>
  auto visit_current(Use use) {
    if (auto* single = std::get_if<1>(&run_)) return use(*single);
    return use(*std::get_if<2>(&run_));
  }
  void take_up(const CheckpointReader& in);
  void part_start();
  void begin_sewing();
  double let_fall();
  double weld_share_at_frame_end();
  double end_of_pull() const;
  bool is_adaptive() const;
  void go_on() const;
  void make_run();
  void remake_run();
  void apply_forces();
  void restart_rest();
  void wake_all();
  template <class T>
  double sew(std::unique_ptr<Run<T>>& current, bool frame_ends, StepReport& report);
  template <class T>
  double weld(std::unique_ptr<Run<T>>& current, Welding<T> welding);
  void update_closing_times(bool frame_ends);
  std::vector<std::vector<std::array<Index, 2>>> refine_if_sewn();
  void sew_as(const Sewing& to, const Vec3<double>& origin);
  std::string live_bytes();
  bool set_live(const std::string& bytes, const std::string& file);
  void load(const CheckpointReader& in, bool counted);
  bool counts();

  Scene scene_;
  LiveInputs live_;
  Fingerprint fingerprint_;  ///< of the scene as it was given
  Scene as_read_;            ///< before refinement; empty unless it asks for that
  std::vector<Seam> seams_as_read_;
  Sewing sewing_;
  std::optional<Vec3<double>> sewn_gravity_;  ///< of a scene whose garments springs close
  bool weightless_ = false;                   ///< until seams are closed, see let_fall()
  AdaptiveRun adaptive_;                      ///< of an adaptive method
  std::size_t pairs_as_read_ = 0;
  FrameClock clock_;
  RestCount rest_;
  DeviceSet& devices_;
  Runs run_;
};

}  // namespace weft
