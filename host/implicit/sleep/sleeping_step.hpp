#pragma once

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "host/implicit/sleep/rest_boxes.hpp"
#include "host/implicit/step.hpp"
#include "host/model/model_part.hpp"

namespace weft {

/// Steps of the implicit method that leave out what is at rest (ImplicitSettings::sleep_distance).
///
/// Sleep. Cloth is taken piece by piece (cloth_components()). At the beginning of every window of
/// steps each vertex gets a mark, the mean of where it was in the last two steps: between these,
/// contacts may go to and fro. A piece' excursion is how far one of its vertices has been from its
/// mark in the window, its drift how far marks have come, and its bend how far a mark is from where
/// two windows of constant velocity would have led. A piece falls asleep at a window's end if
///   spent + excursion + drift n + bend n^2 / 2 <= sleep_distance,
/// n the windows that are left of the run and spent the same sum of its sleeps so far, if the
/// excursion does not exceed that of the window before by more than a hundredth, or rounding, and
/// if nothing that is awake comes near. So what it departs from a run without sleep is bounded by
/// sleep_distance as long as what slows down by itself does not speed up by itself again: a
/// harmonic motion of amplitude a and frequency w has a bend of a w^2, so that one that fits at its
/// turning point stays within the bound for good; what leaves an unstable balance is awake once
/// its growth shows, and what would only begin to leave it after it has fallen asleep does not.
///
/// Asleep, its velocities are zero, and it is in none of the systems, boxes and pairs: these are
/// those of a ModelPart. Its contacts keep what they remember.
///
/// It wakes, before a step, if its pins or handles let go or move in the step, if the bound no
/// longer holds (a run that is resumed with more frames), or if it is near to a triangle of an
/// obstacle that moves or of cloth that is awake: nearer than two thicknesses to the box around the
/// triangle's predicted motion, so that no contact of awake and sleeping cloth is ever left out;
/// what it wakes may wake more. If the motion itself came near a sleeper, the step is done again
/// from its start with that one awake. Pieces in touch sleep and wake together.
///
/// All of this is decided from the state alone, and so the same for any number of ranks.
template <class T>
class SleepingStep final : public StepMethod {
 public:
  /// @param whole steps of all of the store, for when nothing sleeps
  /// @throws DeviceError unless all ranks are on the host
  SleepingStep(Store<T>& store, ImplicitStep<T>& whole);

  void advance(double dt, StepReport& report) override;
  void publish_on(ProgressBoard& board) override { whole_.publish_on(board); }

 private:
  /// What is awake, with a store of its own.
  struct Awake {
    ModelPart part;  ///< its model is the store's
    Store<T> store;
    ImplicitStep<T> step;
    std::vector<ContactMemory<T>> faces, edges;  ///< of what sleeps

    Awake(Store<T>& whole, ModelPart of_it)
        : part(std::move(of_it)),
          store(whole.scene(), whole.devices(), std::move(part.model)),
          step(store) {}
  };

  bool sleeps(std::size_t piece) const { return store_.sleep.pieces[piece].since >= 0; }
  bool sleeps(const Tri& t) const {
    return sleeps(static_cast<std::size_t>(component_of_[static_cast<std::size_t>(t.v[0])]));
  }
  bool any_sleeps() const;
  Span<const Vec3<T>> positions() const { return store_.rank(0).positions.span(); }
  SleepCauses causes() const;
  double departure(const SleepComponent& piece, std::int64_t to_step) const;
  std::int64_t last_step() const;
  void take_state();
  Vec3<double> mean_of_two(std::size_t vertex) const;
  void close_window();
  void wake(std::size_t piece, StepReport& report);
  void wake_pulled(double time, StepReport& report);
  void wake_approached(double dt, StepReport& report);
  std::vector<Vec3<T>> predicted(double dt) const;
  void make_boxes();
  void lay_down(StepReport& report);
  void make_awake();
  StateSnapshot<T> state_of_part(Awake& part) const;
  bool advance_awake(double dt, StepReport& report);
  void advance_obstacles(double dt);
  void write_back();
  void write_contacts();
  void note_excursions();
  void report_sleep(StepReport& report) const;

  Store<T>& store_;
  ImplicitStep<T>& whole_;
  std::vector<Index> component_of_;  ///< [cloth vertices]
  std::size_t component_count_ = 0;
  bool laid_down_ = false;  ///< who falls asleep in this step has lost its velocities
  bool open_seams_ = false;
  std::int64_t window_ = 1;              ///< steps
  std::int64_t steps_ = 0;               ///< of the run
  std::int64_t restores_ = -1;           ///< of the state that the rest was made for
  std::unique_ptr<Awake> awake_;         ///< null: not made
  std::vector<unsigned char> left_out_;  ///< [pieces] that awake_ does without
  RestBoxes boxes_;                      ///< of what has slept since they were made
  std::vector<Vec3<double>> placed_;     ///< obstacles at the step's end
};

}  // namespace weft
