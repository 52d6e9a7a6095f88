#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "host/app/run/run_device.hpp"
#include "host/app/run/step_log.hpp"
#include "host/lab/check/displaced_verdict.hpp"
#include "weft/report.hpp"
#include "weft/simulation.hpp"

namespace weft::app {

/// A strain limit may be exceeded by this share of it before that is a warning.
inline constexpr double limit_excess_max = 0.01;

/// All of a run that its report sums up; recomputed from steps.jsonl when a run is resumed.
class RunTotals {
 public:
  /// Takes the energy at the start of the run as the reference of the drift.
  explicit RunTotals(const Energy& start);

  void add(const StepLine& line);

  /// Change of the total energy since the start over the largest magnitude of the total seen at
  /// frames, the start included; none if that is zero.
  std::optional<double> drift(const Energy& now) const;

  /// The warning at the end of a run that exceeded strain limits; empty: it kept them.
  std::string exceeded_limits() const;

  std::int64_t steps = 0;  ///< that were added
  double wall = 0;         ///< [s]
  StageTimes stages;       ///< [s] in all steps
  std::int64_t solves = 0;
  std::int64_t iterations = 0;
  int iterations_max = 0;  ///< in one solve
  double residual_max = 0;
  std::int64_t proximities_max = 0;
  std::int64_t impacts = 0;
  /// Steps with, or without, the proof that cloth stays apart from itself.
  struct Certified {
    std::int64_t steps = 0;
    double seconds = 0;      ///< wall time of contacts and certification
    double certificate = 0;  ///< of these, of proofs
    void add(const StepReport& r) {
      ++steps;
      seconds += r.stages.contacts + r.stages.resolve_collisions;
      certificate += r.certificate_seconds;
    }
  };
  Certified with_certificate, without_certificate;
  int zones_max = 0;
  int zone_rounds_max = 0;
  int zone_largest = 0;
  std::int64_t zone_passes = 0;
  std::int64_t zones_unsolved = 0;
  std::int64_t plane_zones = 0;
  std::int64_t rigid_zones = 0;
  std::int64_t truncations = 0;
  double compliance_distance_max = 0;  ///< [m]
  /// The largest by which a strain limit is exceeded at a frame, see StepReport; empty: no limits.
  std::optional<double> limit_excess{};
  std::int64_t retries = 0;
  AsynchronousCounts asynchronous;                        ///< zeros with other methods
  std::array<std::int64_t, 5> steps_at_fallback_level{};  ///< by Fallback level
  std::int64_t remeshes = 0;                              ///< after steps; the rest sums these up
  RemeshReport remesh;     ///< sums; of vertices, triangles and energy_jump the largest
  double kinetic_max = 0;  ///< [J] at frames
  SleepReport sleep;       ///< sums; of pieces and departure the largest
  /// Steps of automatic length.
  struct Automatic {
    std::int64_t steps = 0;
    double shortest = 0, longest = 0;  ///< [s]
    double error_max = 0;              ///< over the tolerance
    std::int64_t rejected = 0;         ///< attempts
    void add(const StepReport& r);
  };
  Automatic automatic;
  BalanceReport balance;  ///< sums; of imbalance_before and _after the latest

 private:
  void add_remesh(const RemeshReport& r);
  void add_sleep(const SleepReport& r);

  double start_;
  double largest_;
};

/// What the report says beside the simulation and the totals.
struct RunFacts {
  RunDevice device;
  lab::DisplacedVerdict verdict;                ///< of the state at the end
  bool at_frame = true;                         ///< that state is the last frame
  std::optional<std::string> failure;           ///< why the run stopped before its end
  std::optional<Vec3<double>> failure_place{};  ///< [m] see StepReport
  std::optional<double> energy_gain{};          ///< [J] see EnergyBalance; none: not known
};

/// report.json: stages_ms are sums over all steps; intersections are those of the last frame.
nlohmann::ordered_json make_report(const Simulation& simulation, const RunTotals& totals,
                                   const RunFacts& facts);

/// 16 hexadecimal digits.
std::string hash_text(std::uint64_t hash);

}  // namespace weft::app
