#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "host/implicit/linear/contact_buffers.hpp"
#include "host/implicit/linear/element_buffers.hpp"
#include "host/implicit/linear/held_components.hpp"
#include "host/implicit/linear/krylov_vectors.hpp"
#include "host/implicit/linear/line_search_vectors.hpp"
#include "host/implicit/linear/mesh_matrix.hpp"
#include "host/implicit/linear/moving_frame_buffers.hpp"
#include "host/implicit/linear/pipelined_solve.hpp"
#include "host/implicit/linear/plate_operator.hpp"
#include "host/implicit/linear/preconditioner_buffers.hpp"
#include "host/implicit/linear/step_energy_buffers.hpp"
#include "host/implicit/tracking/tracking.hpp"
#include "host/state/rank_geometry.hpp"
#include "weft/kernels/solve/pcg.hpp"
#include "weft/state/contact.hpp"

namespace weft {

/// The point about which the system is linearised: the start of the step x_n, v_n, and the iterate
/// x_k, v_k.
struct Linearisation {
  double h = 0;  ///< [s] effective step of the integrator
  /// x_k is x_n with each component moved as a rigid body: elements see x_n turned
  bool moved = false;
  double turned_dt = 0;  ///< [s] step that triangles turn for beside, see TurnedStart; 0: none do
  bool without_rates = false;  ///< v_k is constant per component, so strain rates are 0
  bool predicted = false;      ///< the active set is the predicted one: there is only one iteration
  bool refresh = true;         ///< rebuild the preconditioner's aggregates
};

/// Products of a line search, see SolveProducts.
struct ResidualProducts {
  double slope = 0;     ///< [N m] b . dv
  double residual = 0;  ///< [N s] |b|
};

/// Energies of a step, see AssembleStepEnergy. [J]
struct StepEnergy {
  double at_start = 0;
  double turned = 0;
  double limited = 0;
};

/// When a linear solve ends or pauses, see SolvePcg.
struct SolveRules {
  double reference = 0;  ///< [N s] what the residual is compared with, at least
  double scale = 0;      ///< [sqrt(J)] the same, preconditioned: that of the solve to be repeated
  double accept = 0;     ///< an initial guess with at most this share of both is the solution
  double gain = 0;       ///< this share of the initial residual will do; 0: as the tolerance asks
  bool keep = false;     ///< both hardly grow with the initial residual: the solve ends no earlier
  double pause = 0;      ///< pauses at this share of the initial residual; 0: never
  bool resume = false;   ///< goes on with the latest solve, which has paused
  /// The solve pauses once vertices are where they belong, see SolvePcg::pause_left: what several
  /// components of cloth ask for beyond that matters once their contacts are right.
  bool pause_for_contacts = false;
};

/// The system (M - h^2 J) dv = b (P-Cloth eq. (3)) over all ranks: assembly and solution.
template <class T>
class LinearSystem {
 public:
  LinearSystem(Store<T>& store, std::vector<RankGeometry<T>>& geometry,
               std::vector<RankMotion<T>>& motion);

  /// Arrays of rank r that the caller fills before assemble().
  Buffer<Vec3<T>>& iterate_positions(int r) { return rank(r).iterate_positions; }
  Buffer<Vec3<T>>& iterate_velocities(int r) { return rank(r).iterate_velocities; }
  /// The same for Linearisation::moved.
  MovingFrameBuffers<T>& moving_frame(int r) { return rank(r).moving_frame; }
  /// Triangles as a system about such a point has them. In the memory of rank r.
  TurnedStart<T> turned_start(int r, const Linearisation& at) const;

  /// Sets the fixed vertices of systems assembled from now on. Triangles with three fixed corners
  /// add no bending energy. Waits for the ranks if these vertices change.
  /// @param fixed [vertices] see fixed_vertices()
  void hold(const std::vector<unsigned char>& fixed);

  /// Adopts the store's partition after it has changed, and rebuilds all data of the ranks' rows.
  /// Springs have to be set again. Waits for the ranks.
  void share_rows();

  /// Submits a copy of the ranks' contact counts to the host.
  void ask_row_work();
  /// [bytes] that an iteration of conjugate gradients reads and writes, by rank.
  /// @pre the latest ask_row_work() is done
  std::vector<double> row_work() const;
  /// The same for each reduction block. Waits for the ranks.
  std::vector<double> partial_work();

  /// Springs of the systems assembled from now on, for all ranks, after hold(). Waits for the
  /// ranks.
  void set_springs(const std::vector<Spring<T>>& springs);

  /// Sets linear constraints on later solutions: sums that they must have; null: none. On the host,
  /// with a single rank.
  void track(TrackedSystem* tracked) { tracked_ = tracked; }

  /// Assembles on all ranks. `contacts(r)` returns all contacts, in the memory of rank r.
  template <class Contacts>
  void assemble(const Linearisation& at, Contacts contacts) {
    take_compression();
    for (int r = 0; r < store_.devices().size(); ++r) assemble_rank(r, at, contacts(r));
  }

  /// Replaces the contacts of the assembled system; the latest solution becomes the initial guess.
  template <class Contacts>
  void replace_contacts(const Linearisation& at, Contacts contacts) {
    for (int r = 0; r < store_.devices().size(); ++r) assemble_contacts_of(r, at, contacts(r));
  }

  /// See PipelinedSolve; for benchmarks. Has no effect with the transport peer.
  void gather_before_products(bool gather) {
    if (pipelined_) pipelined_->gather_before_products(gather);
  }

  /// Solves on all ranks; velocities_t1 of every rank then holds v_k + dv in its own rows. With the
  /// transport pipelined the caller waits for the solve.
  void launch_solve(const Linearisation& at, const SolveRules& rules);

  /// [N s] 2-norm of the impulses of gravity on all cloth vertices in a step of length h
  double weight_impulse(double h) const {
    return h * store_.model().whole.mass_2_norm * length(store_.scene().gravity);
  }

  /// Saves v_k and dv for move_along(), before the system is assembled at another point.
  void begin_line();
  /// velocities_t1 of own rows = saved v_k + share times saved dv, on all ranks.
  void move_along(double share);
  /// Products of the assembled right-hand side with the saved dv. Waits for the ranks.
  ResidualProducts products();

  /// Energies of the motion from the state to positions_t1. Waits for the ranks.
  StepEnergy step_energy();
  /// The same, with errors of a system about another point.
  StepEnergy step_energy(const Linearisation& at);
  /// The same for a motion that starts elsewhere.
  /// @param positions, velocities [ranks] of all vertices [m], [m/s]
  StepEnergy step_energy(const std::vector<Span<const Vec3<T>>>& positions,
                         const std::vector<Span<const Vec3<T>>>& velocities,
                         const Linearisation& at = {});
  /// Kinetic energy of the state. Waits for the ranks.
  /// @return [J]
  double kinetic_energy();

  /// Outcome of the latest solve. Waits for rank 0.
  SolveStatus status();

 private:
  /// Data of a rank's rows.
  struct Rank {
    RankRows own;
    ElementBuffers<T> elements;
    MeshMatrix<T> mesh;
    PlateOperator<T> plate;
    ContactBuffers<T> contacts;
    PreconditionerBuffers<T> preconditioner;
    KrylovVectors<T> krylov;
    Buffer<Vec3<T>> iterate_positions, iterate_velocities;
    MovingFrameBuffers<T> moving_frame;
    LineSearchVectors<T> line;
    StepEnergyBuffers<T> energy;
  };

  Rank& rank(int r) { return ranks_[static_cast<std::size_t>(r)]; }
  const Rank& rank(int r) const { return ranks_[static_cast<std::size_t>(r)]; }
  const RankGeometry<T>& geometry(int r) const { return geometry_[static_cast<std::size_t>(r)]; }
  RankMotion<T>& motion(int r) { return motion_[static_cast<std::size_t>(r)]; }
  void make_rank(int r);
  void make_ranks();
  void take_compression();
  /// Rows per reduction block of a solve.
  Index partial_rows() const;
  void assemble_rank(int r, const Linearisation& at, Span<const Contact<T>> contacts);
  void assemble_mesh(int r, const Linearisation& at);
  void assemble_contacts_of(int r, const Linearisation& at, Span<const Contact<T>> contacts);
  void launch_initial_guess(int r, const Linearisation& at, Span<const Contact<T>> contacts);
  typename PreconditionerBuffers<T>::Of matrix(int r) const;
  SolvePcgPart<T> part(int r);
  TrackedRows tracked_rows(const Linearisation& at);
  bool all_fall() const;
  double misplaced_left(double h) const;
  double left_with_contacts(double h) const;
  double fall_scale(double h) const;

  Store<T>& store_;
  std::vector<RankGeometry<T>>& geometry_;
  std::vector<RankMotion<T>>& motion_;
  std::vector<Rank> ranks_;
  std::shared_ptr<const PlateMatrix> plate_;  ///< source of the ranks' plate rows
  TrackedSystem* tracked_ = nullptr;
  HeldComponents<T> held_;
  /// [ranks] of the latest ask_row_work()
  std::vector<typename ContactBuffers<T>::Counts> contact_counts_;
  std::uint64_t compression_epoch_ = 0;         ///< of the compression that the ranks hold
  Index halo_epoch_ = 0;                        ///< number of the latest ghost list
  std::uint32_t pcg_epoch_ = 0;                 ///< see SolvePcg::epoch
  std::vector<SolvePcgPart<T>> parts_;          ///< host copy while it is uploaded
  std::optional<PipelinedSolve<T>> pipelined_;  ///< empty: the transport is peer
};

}  // namespace weft
