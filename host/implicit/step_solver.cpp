#include "host/implicit/step_solver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "host/implicit/parallel/exchange.hpp"
#include "host/implicit/step_failure.hpp"
#include "host/model/material_rows.hpp"
#include "host/model/springs.hpp"
#include "weft/kernels/assemble/active_set_update.hpp"
#include "weft/kernels/integrate/advance.hpp"
#include "weft/kernels/integrate/moving_frame.hpp"
#include "weft/kernels/integrate/rate.hpp"
#include "weft/kernels/solve/held_components.hpp"

namespace weft {
namespace {

/// Residuals are checked against at least this share of what gravity does in a step: at a tolerance
/// of 1e-3 that leaves velocities wrong by 1e-4 of h g.
constexpr double weight_share = 0.1;

/// A step along the line is good once the slope there is at most this share of the slope at its
/// beginning (Matthies & Strang 1979).
constexpr double slope_share = 0.9;
constexpr int line_steps_max = 10;

/// What a linear solve may miss of the energy of stretching, see AssembleStretchError, over all
/// energy at the start of the step: at strain limits, and by turning. What it misses by turning may
/// also be so many times the kinetic energy there. All include what gravity adds. Chosen in
/// docs/decisions/003-linear-solve.md.
constexpr double limited_share_max = 0.005;
constexpr double missed_share_max = 0.002;
constexpr double turned_share_max = 3;
/// While seams pull, or where cloth is jammed, turning may add so much to all energy at the start:
/// what dissipates is welcome there.
constexpr double dissipated_share_max = 1e4;
/// Newton's method then goes on until its residual is this share of the first, in both norms.
constexpr double refined_residual = 0.01;
/// Its linear solves have this share of the tolerance.
constexpr double refined_tolerance = 0.1;
/// All but the first and the last end early where they have come to this share of the residual that
/// they began with: before Newton's method has converged, what is left is mostly what is not
/// linear.
/// Not while seams pull: the panels of an inflated cushion then fold beside its seam.
constexpr double refined_gain = 0.1;
constexpr int refinements_max = 20;

/// How often a step's linear system is solved again because its contacts turn out otherwise.
constexpr int active_set_iterations_max = 3;
constexpr int active_set_iterations_draping = 1;
/// That many tolerances of the solve may what contacts turn out to be differ from what they were
/// taken for.
constexpr double active_set_share = 10;
/// Share of its residual at which a solve with contacts looks which of them push. Chosen in
/// docs/decisions/002-contacts.md.
constexpr double early_share = 0.03;
/// So much of its weight may friction on a component of cloth, all together, be off. Chosen in
/// docs/decisions/002-contacts.md.
constexpr double friction_missed_max = 0.1;
/// So much of a component's weight and of what contacts push may others pull at it, all together.
/// Chosen there as well.
constexpr double pull_max = 1;

/// Whether only the end of the motion counts: garments go on until they rest. A linear solve loses
/// energy where Newton's method would keep it, and they rest earlier.
bool is_draping(const Scene& scene) {
  return !scene.garment_starts.empty() && scene.time.until == RunUntil::rest;
}

}  // namespace

template <class T>
StepSolver<T>::StepSolver(Store<T>& store, const std::vector<RankGeometry<T>>& geometry,
                          std::vector<RankMotion<T>>& motion, ContactDetection<T>& detection,
                          LinearSystem<T>& system, StageClock& clock,
                          const StepPublisher& publisher)
    : store_(store),
      geometry_(geometry),
      motion_(motion),
      detection_(detection),
      system_(system),
      clock_(clock),
      publisher_(publisher) {
  for (int r = 0; r < store.devices().size(); ++r) {
    rank_mismatch_.emplace_back(store.devices()[r]);
    rank_mismatch_of_contact_.emplace_back(store.devices()[r]);
    rank_force_.emplace_back(store.devices()[r]);
  }
}

template <class T>
void StepSolver<T>::set_springs(double time, double step) {
  std::vector<Spring<T>> springs;
  seams_pull_ = false;
  for (const Spring<double>& s : springs_at(store_.scene(), store_.model(), time, step)) {
    springs.push_back({{s.v[0], s.v[1]},
                       vec_cast<T>(s.anchor),
                       static_cast<T>(s.stiffness),
                       static_cast<T>(s.rest),
                       vec_cast<T>(s.along),
                       static_cast<T>(s.drag)});
    seams_pull_ = seams_pull_ || s.v[1] >= 0;
  }
  detection_.let_seams_close(seams_pull_);
  system_.set_springs(springs);
}

template <class T>
bool StepSolver<T>::solve(const Attempt& a, StepReport& report) {
  rules_ = {};
  refined_ = false;
  switch (store_.scene().solver.newton_iterations) {
    case 0:
      return solve_once(a, report) && refine(a, report);
    case 1:
      return solve_once(a, report);
    default:
      return solve_newton(a, report);
  }
}

/// The linearly implicit step. Where something stops what turned, the start as it is misses less of
/// how cloth stretches than the start turned.
template <class T>
bool StepSolver<T>::solve_once(const Attempt& a, StepReport& report) {
  report.newton_iterations += 1;
  return solve_about_start(a, report, true) &&
         (!turned_in_vain() || solve_about_start(a, report, false));
}

/// Whether the latest solve would have missed less with no component turned.
template <class T>
bool StepSolver<T>::turned_in_vain() {
  return at_.moved && system_.turned() &&
         system_.step_energy(at_).turned > system_.step_energy().turned;
}

/// P-Cloth eq. (3).
/// @param turn whether components that turn are linearised about the start turned
template <class T>
bool StepSolver<T>::solve_about_start(const Attempt& a, StepReport& report, bool turn) {
  start_at_state(a, turn);
  at_ = {.h = a.h, .moved = true, .without_rates = a.at_rest, .predicted = true};
  assemble();
  const bool solved =
      solve_with_early_look(a, {weight_share * system_.weight_impulse(a.h)}, report);
  book_assembly(report);
  return solved && iterate_active_set(a, report);
}

/// Newton's method on the step's own equations, with a line search: the true step of backward
/// Euler, or BDF2. Starts where everything would end with its present velocity.
template <class T>
bool StepSolver<T>::solve_newton(const Attempt& a, StepReport& report) {
  const SolverSettings& settings = store_.scene().solver;
  start_at_prediction(a);
  at_ = {.h = a.h};
  assemble();
  for (int k = 0; k < settings.newton_iterations; ++k) {
    report.newton_iterations += 1;
    const double floor = k == 0 ? weight_share * system_.weight_impulse(a.h)
                                : settings.newton_tolerance * first_reference_;
    if (!finish_solve(a, {floor}, report)) return false;
    if (k == 0) {
      book_assembly(report);
      first_reference_ = rules_.reference;
    }
    if (!search_line(a, report)) return false;
    if (report.newton_residual <= settings.newton_tolerance) break;
  }
  // The system now stands at the last iterate, where solve_again may go on from.
  return true;
}

/// Newton's method for an attempt whose linear solve is not good enough. Linear solves may fall
/// short of their tolerance here: what conjugate gradients have come to leads downhill.
template <class T>
bool StepSolver<T>::refine(const Attempt& a, StepReport& report) {
  const bool begins = !refined_;
  SolveRules whole = rules_;
  if (begins) {
    if (is_nearly_linear(a)) return true;
    refined_ = true;
    first_reference_ = rules_.reference;
    start_at_prediction(a);
    at_ = {.h = a.h, .refresh = false};
    assemble();
    whole = {refined_tolerance * rules_.reference, refined_tolerance * rules_.scale,
             refined_residual / refined_tolerance};
  }
  // Where little is not linear, the first solve is all there is to do. Where it begins is never the
  // outcome.
  SolveRules rules = begins ? SolveRules{weight_share * system_.weight_impulse(a.h)} : whole;
  for (int k = 0; k <= refinements_max; ++k) {
    const int iterations = report.iterations;
    const bool solved = finish_solve(a, rules, report, true);
    if (begins && k == 0) {
      // The linear solve may have begun with contacts that push by far more than all there is to
      // solve for here, as cloth would end deep in a body.
      first_reference_ = std::min(first_reference_, rules_.reference);
      whole.reference = std::min(whole.reference, refined_tolerance * rules_.reference);
      whole.scale = std::min(whole.scale, refined_tolerance * rules_.scale);
      rules = whole;
    }
    rules_ = whole;
    if (!solved) return false;
    if (report.iterations == iterations) {
      if (!(rules.gain > 0)) return true;
      // Converged but for what the last solve has left.
      rules.gain = rules.accept = 0;
      continue;
    }
    if (k == refinements_max) break;
    ++report.newton_iterations;
    if (!search_line(a, report)) return false;
    if (!(rules.accept > 0)) return true;
    if (!seams_pull_) rules.gain = refined_gain;
  }
  const bool converged = report.newton_residual <= 1;
  const bool broken = converged && store_.backoff.stretched == 0 && !keeps_limits();
  if (converged && (!broken || a.must_stand)) return true;
  if (!a.must_stand)
    return fail(report, Failure::not_converged,
                "Newton's method stopped at " + std::to_string(report.newton_residual) +
                    " of its first residual after " + std::to_string(refinements_max) +
                    " iterations");
  // No step is shorter.
  refined_ = false;
  rules_ = {};
  return solve_once(a, report);
}

/// Whether no triangle has gone past a strain limit in this step.
template <class T>
bool StepSolver<T>::keeps_limits() {
  return !has_limits(store_.model().laws->rows) || std::isfinite(system_.step_energy().limited);
}

/// Whether cloth stretches and turns little enough for a single linear solve.
template <class T>
bool StepSolver<T>::is_nearly_linear(const Attempt& a) {
  const StepEnergy energy = system_.step_energy(at_);
  const double fall = length(store_.scene().gravity) * a.h;
  const double fall_energy = 0.5 * store_.model().whole.mass * fall * fall;
  const double at_play = energy.at_start + fall_energy;
  // Also false if something is not finite: Newton's method may do better.
  if (!(energy.limited <= limited_share_max * at_play)) return false;
  if (energy.turned <= missed_share_max * at_play ||
      energy.turned <= turned_share_max * fall_energy)
    return true;
  if (is_draping(store_.scene())) return true;
  const bool jammed = truncating_ || store_.backoff.truncated > 0;
  if (seams_pull_ || jammed) return energy.turned <= dissipated_share_max * at_play;
  return energy.turned <= turned_share_max * (system_.kinetic_energy() + fall_energy);
}

/// Goes along dv until the residual no longer has much of a component in its direction: for forces
/// that have a potential that is where the potential is least. Asks for the residual alone, so it
/// serves forces without a potential as well. Leaves the system assembled where it ends.
template <class T>
bool StepSolver<T>::search_line(const Attempt& a, StepReport& report) {
  system_.begin_line();
  const ResidualProducts start = system_.products();
  at_.refresh = false;
  double low = 0;
  double high = 1;
  double slope_low = start.slope;
  double slope_high = 0;
  double share = 1;
  for (int n = 0;; ++n) {
    if (n > 0) {
      system_.move_along(share);
      spread_solution(a);
    }
    take_iterate();
    assemble();
    const ResidualProducts here = system_.products();
    book_assembly(report);
    if (!std::isfinite(here.residual))
      return fail(report, Failure::not_finite, "the residual of Newton's method is not finite");
    report.newton_residual = first_reference_ > 0 ? here.residual / first_reference_ : 0;
    const bool good = here.slope >= -slope_share * std::abs(start.slope) ||
                      here.residual <= (1 - 1e-4) * start.residual;
    if (!store_.scene().solver.line_search || good || n == line_steps_max) return true;
    ++report.line_steps;
    // The slope changes its sign between low and high: regula falsi, kept away from both ends.
    (here.slope > 0 ? low : high) = share;
    (here.slope > 0 ? slope_low : slope_high) = here.slope;
    const double root = low + (high - low) * slope_low / (slope_low - slope_high);
    share = std::clamp(root, low + 0.1 * (high - low), high - 0.1 * (high - low));
  }
}

template <class T>
bool StepSolver<T>::solve_again(const Attempt& a, StepReport& report) {
  const int newton_iterations = store_.scene().solver.newton_iterations;
  // The search takes contacts for what they were in the last step. Of friction between several
  // cloths the solve knows better. Layers of one cloth in a jam would come closer to each other.
  const bool several = geometry_[0].component_inverse_mass.size() > 1;
  if (several && !refined_ && newton_iterations <= 1) update_active_set({.parted = true});
  system_.replace_contacts(at_, [this](int r) { return detection_.contacts(r); });
  const SolveRules rules = rules_;
  if (refined_) {
    if (!finish_solve(a, rules, report, true)) return false;
    rules_ = rules;
    return search_line(a, report) && refine(a, report);
  }
  if (newton_iterations > 1) return finish_solve(a, rules, report) && search_line(a, report);
  return solve_with_early_look(a, rules, report) && iterate_active_set(a, report) &&
         (!turned_in_vain() || solve_about_start(a, report, false)) &&
         (newton_iterations == 1 || refine(a, report));
}

/// Solves to the tolerance. Where there are contacts, it pauses early and looks which of them push:
/// if these are not those that it was made for, only its beginning has been in vain, else it is
/// resumed. Friction is left to whole solves: chosen in docs/decisions/002-contacts.md.
template <class T>
bool StepSolver<T>::solve_with_early_look(const Attempt& a, SolveRules rules, StepReport& report) {
  if (detection_.contacts(0).empty()) return finish_solve(a, rules, report);
  rules.pause = early_share;
  if (!finish_solve(a, rules, report)) return false;
  const bool right = is_right(update_active_set({.early = true, .compare = true}));
  if (right && !paused_) return true;
  rules.pause = 0;
  rules.pause_for_contacts = a.whole;
  if (right) {
    rules.resume = true;
  } else {
    ++report.active_set_iterations;
    update_active_set({.early = true});
    system_.replace_contacts(at_, [this](int r) { return detection_.contacts(r); });
    rules = rules_;
    rules.keep = true;
    rules.pause_for_contacts = a.whole;
  }
  return finish_solve(a, rules, report);
}

/// A single linear solve has to guess which contacts push and what their friction is. Where its
/// solution says otherwise, by more than the tolerance of the solve, or so that friction would push
/// a component of cloth off, it is repeated with what the solution says. Newton's method needs none
/// of this.
template <class T>
bool StepSolver<T>::iterate_active_set(const Attempt& a, StepReport& report) {
  const int iterations_max =
      is_draping(store_.scene()) ? active_set_iterations_draping : active_set_iterations_max;
  for (int k = 0; k < iterations_max; ++k) {
    const bool last = k + 1 == iterations_max;
    if (paused_ && is_right(update_active_set({.compare = true, .last = last}))) {
      SolveRules rules = rules_;
      rules.resume = true;
      if (!finish_solve(a, rules, report)) return false;
    }
    // Only whole solves show which contacts are crushed.
    if (is_right(update_active_set({.may_become_firm = a.whole && !paused_, .last = last})))
      return true;
    ++report.active_set_iterations;
    system_.replace_contacts(at_, [this](int r) { return detection_.contacts(r); });
    SolveRules rules = rules_;
    rules.pause_for_contacts = a.whole && !last;
    if (!finish_solve(a, rules, report)) return false;
  }
  return true;
}

/// Whether contacts are what the last solve took them for.
template <class T>
bool StepSolver<T>::is_right(const ContactMismatch& mismatch) const {
  const double share = active_set_share * store_.scene().solver.tolerance;
  return mismatch.impulse <= share * rules_.reference && mismatch.friction <= friction_missed_max &&
         mismatch.pull <= pull_max;
}

template <class T>
bool StepSolver<T>::solve_about_state(const Attempt& a, StepReport& report) {
  const auto cloth = static_cast<std::size_t>(store_.model().cloth_vertex_count);
  for (int r = 0; r < store_.devices().size(); ++r) {
    const RankMotion<T>& m = motion_[static_cast<std::size_t>(r)];
    Queue& queue = store_.devices()[r].compute();
    Buffer<Vec3<T>>& x = system_.iterate_positions(r);
    queue.copy(x.data(), store_.rank(r).positions.data(), cloth * sizeof(Vec3<T>));
    queue.copy(x.data() + cloth, m.positions_t1.data() + cloth,
               (x.size() - cloth) * sizeof(Vec3<T>));
    launch(queue, IntegrateRate<T>{x.span(), m.base_positions.span(), static_cast<T>(a.h),
                                   system_.iterate_velocities(r).span()});
  }
  at_ = {.h = a.h, .predicted = true};
  assemble();
  ++report.newton_iterations;
  const bool solved = finish_solve(a, {}, report);
  book_assembly(report);
  return solved && iterate_active_set(a, report);
}

/// By how much contacts are not what the last solve took them for; all ranks then take them for
/// what they are, unless they are to be compared only.
template <class T>
ContactMismatch StepSolver<T>::update_active_set(const ActiveSet& how) {
  if (detection_.contacts(0).empty()) return {};
  DeviceSet& devices = store_.devices();
  const double gravity = length(store_.scene().gravity);
  const auto h = static_cast<T>(at_.h);
  const bool shared = devices.size() > 1 && share_memory(devices);
  if (shared) join_ranks(devices);
  for (int r = 0; r < devices.size(); ++r) {
    const auto n = static_cast<std::size_t>(r);
    const RankGeometry<T>& g = geometry_[n];
    Queue& queue = devices[r].compute();
    const Span<Contact<T>> contacts = detection_.contacts_to_change(r);
    rank_mismatch_[n].resize(1);
    rank_mismatch_of_contact_[n].resize(shared ? contacts.size() : 0);
    rank_force_[n].resize(component_sums * g.component_inverse_mass.size());
    queue.fill(rank_force_[n].data(), 0, rank_force_[n].size() * sizeof(std::int64_t));
    launch(queue,
           AssembleActiveSetUpdate<T>{
               contacts, motion_[n].positions_t1.span(), store_.rank(r).positions.span(),
               g.component_of_vertex.span(), g.component_inverse_mass.span(),
               store_.model().cloth_vertex_count, h, gravity > 0 ? 1 / gravity : 0,
               how.may_become_firm ? store_.rank(r).touched.span() : Span<const unsigned char>(),
               how.last, how.early, how.compare, how.parted, rank_mismatch_[n].span(),
               rank_force_[n].span(), rank_mismatch_of_contact_[n].span()});
  }
  double mismatch_sq = 0;
  std::vector<std::int64_t> force(rank_force_[0].size());
  if (shared) {
    sync_ranks(devices);
    for (std::size_t n = 0; n < rank_force_.size(); ++n) {
      for (const double of_contact : rank_mismatch_of_contact_[n].span()) mismatch_sq += of_contact;
      for (std::size_t k = 0; k < force.size(); ++k) force[k] += rank_force_[n].data()[k];
    }
    mismatch_sq *= static_cast<double>(h * h);
  } else {
    Queue& queue = devices[0].compute();
    queue.copy(&mismatch_sq, rank_mismatch_[0].data(), sizeof mismatch_sq);
    queue.copy(force.data(), rank_force_[0].data(), force.size() * sizeof(std::int64_t));
    queue.sync();
  }
  const auto weights = [&force](std::size_t first) {
    return std::hypot(static_cast<double>(force[first]), static_cast<double>(force[first + 1]),
                      static_cast<double>(force[first + 2])) /
           weight_one;
  };
  ContactMismatch mismatch{std::sqrt(mismatch_sq)};
  for (std::size_t c = 0; c < force.size(); c += component_sums) {
    mismatch.friction = std::max(mismatch.friction, weights(c));
    const double push = static_cast<double>(force[c + 6]) / weight_one;
    mismatch.pull = std::max(mismatch.pull, weights(c + 3) / (1 + push));
  }
  return mismatch;
}

/// Solves the assembled system and takes the outcome to all ranks.
/// @param may_fall_short a solve that does not converge is no failure
template <class T>
bool StepSolver<T>::finish_solve(const Attempt& a, const SolveRules& rules, StepReport& report,
                                 bool may_fall_short) {
  if (stopped(store_.devices(), report)) return false;
  publisher_.enter(StepStage::solve, report);
  system_.launch_solve(at_, rules);
  spread_solution(a);
  const SolveStatus status = system_.status();
  rules_ = {status.reference, status.scale};
  paused_ = status.paused != 0;
  if (!rules.resume) {
    ++report.solves;
    resumed_from_ = 0;
  }
  publisher_->set_solves(report.solves);
  report.iterations += status.iterations - resumed_from_;
  resumed_from_ = status.iterations;
  report.iterations_max = std::max(report.iterations_max, status.iterations);
  if (!paused_) report.residual_max = std::max(report.residual_max, status.residual);
  if (stopped(store_.devices(), report)) return false;
  if (status.finite == 0)
    return fail(report, Failure::not_finite, "the linear solve met a number that is not finite");
  if (status.converged == 0 && !paused_ && !may_fall_short)
    return fail(report, Failure::not_converged,
                "the linear solve stopped at " + std::to_string(status.residual) +
                    " of its first residual after " + std::to_string(status.iterations) +
                    " iterations");
  return true;
}

template <class T>
void StepSolver<T>::assemble() {
  clock_.mark(StageClock::assembly_begin);
  system_.assemble(at_, [this](int r) { return detection_.contacts(r); });
  clock_.mark(StageClock::assembled);
}

/// Counts the latest assembly as such rather than as part of the solve. Rank 0 has been waited for.
template <class T>
void StepSolver<T>::book_assembly(StepReport& report) {
  const double seconds = clock_.between(StageClock::assembly_begin, StageClock::assembled);
  report.stages.assemble += seconds;
  report.stages.solve -= seconds;
}

/// The iterate is the step's start, x_n, with each component of cloth moved along as a rigid body;
/// obstacles stand where they end.
template <class T>
void StepSolver<T>::start_at_state(const Attempt& a, bool turn) {
  const auto cloth = static_cast<std::size_t>(store_.model().cloth_vertex_count);
  for (int r = 0; r < store_.devices().size(); ++r) {
    Queue& queue = store_.devices()[r].compute();
    RankState<T>& state = store_.rank(r);
    RankMotion<T>& m = motion_[static_cast<std::size_t>(r)];
    const RankGeometry<T>& g = geometry_[static_cast<std::size_t>(r)];
    Buffer<Vec3<T>>& positions = system_.iterate_positions(r);
    queue.copy(positions.data() + cloth, m.positions_t1.data() + cloth,
               (positions.size() - cloth) * sizeof(Vec3<T>));
    MovingFrameBuffers<T>& frame = system_.moving_frame(r);
    queue.fill(frame.turned.data(), 0, sizeof(std::int32_t));
    queue.fill(frame.meets.data(), 0, frame.meets.size() * sizeof(Index));
    if (!detection_.contacts(r).empty())
      launch(queue, SolveHeldComponents<T>{detection_.contacts(r), g.component_of_vertex.span(),
                                           frame.meets.span()});
    launch(queue,
           IntegrateMovingFrame<T>{
               state.positions.span(), state.velocities.span(), g.component_of_vertex.span(),
               g.moving_frame_sample.span(), frame.meets.span(), static_cast<T>(a.dt),
               turn ? static_cast<T>(moving_frame_angle_min) : std::numeric_limits<T>::infinity(),
               0, frame.positions.span(), positions.span(), system_.iterate_velocities(r).span(),
               frame.velocities.span(), frame.turned.span()});
    if (!a.at_rest)
      launch(queue, IntegrateRate<T>{positions.span(), m.base_positions.span(), static_cast<T>(a.h),
                                     system_.iterate_velocities(r).span()});
  }
}

/// The iterate is where present velocities lead, with pinned vertices at their targets. Without
/// what gravity adds to the prediction: cloth at rest would be moved off its solution.
template <class T>
void StepSolver<T>::start_at_prediction(const Attempt& a) {
  for (int r = 0; r < store_.devices().size(); ++r) {
    RankState<T>& state = store_.rank(r);
    RankMotion<T>& m = motion_[static_cast<std::size_t>(r)];
    Queue& queue = store_.devices()[r].compute();
    Buffer<Vec3<T>>& positions = system_.iterate_positions(r);
    queue.copy(positions.data(), m.positions_t1.data(), positions.size() * sizeof(Vec3<T>));
    launch(queue, IntegrateAdvance<T>{state.positions.span(), state.velocities.span(),
                                      geometry_[static_cast<std::size_t>(r)].fixed.span(),
                                      static_cast<T>(a.dt), positions.span()});
    launch(queue, IntegrateRate<T>{positions.span(), m.base_positions.span(), static_cast<T>(a.h),
                                   system_.iterate_velocities(r).span()});
  }
}

/// The iterate is what has been solved last.
template <class T>
void StepSolver<T>::take_iterate() {
  for (int r = 0; r < store_.devices().size(); ++r) {
    RankMotion<T>& m = motion_[static_cast<std::size_t>(r)];
    Queue& queue = store_.devices()[r].compute();
    Buffer<Vec3<T>>& positions = system_.iterate_positions(r);
    queue.copy(positions.data(), m.positions_t1.data(), positions.size() * sizeof(Vec3<T>));
    queue.copy(system_.iterate_velocities(r).data(), m.velocities_t1.data(),
               m.velocities_t1.size() * sizeof(Vec3<T>));
  }
}

/// Own rows of the new velocities to all ranks, and positions from them.
template <class T>
void StepSolver<T>::spread_solution(const Attempt& a) {
  DeviceSet& devices = store_.devices();
  all_gather_rows<Vec3<T>>(devices, store_.partition(), [this](int r) {
    return motion_[static_cast<std::size_t>(r)].velocities_t1.span();
  });
  for (int r = 0; r < devices.size(); ++r) {
    RankMotion<T>& m = motion_[static_cast<std::size_t>(r)];
    launch(devices[r].compute(),
           IntegrateAdvance<T>{m.base_positions.span(), m.velocities_t1.span(),
                               geometry_[static_cast<std::size_t>(r)].fixed.span(),
                               static_cast<T>(a.h), m.positions_t1.span()});
  }
}

template class StepSolver<float>;
template class StepSolver<double>;

}  // namespace weft
