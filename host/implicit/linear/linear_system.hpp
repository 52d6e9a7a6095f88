#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "host/implicit/linear/iteration_bytes.hpp"
#include "host/implicit/linear/mesh_rows.hpp"
#include "host/implicit/linear/pipelined_solve.hpp"
#include "host/implicit/tracking/tracking.hpp"
#include "host/state/rank_geometry.hpp"
#include "weft/kernels/assemble/membrane.hpp"
#include "weft/kernels/assemble/stretch_error.hpp"
#include "weft/kernels/solve/pcg.hpp"
#include "weft/state/contact.hpp"

namespace weft {

/// The point about which the system is linearised: the start of the step x_n, v_n, and the iterate
/// x_k, v_k.
struct Linearisation {
  double h = 0;         ///< [s] effective step of the integrator
  bool translated;      ///< x_k is x_n with each component translated: elements see x_n
  bool without_rates;   ///< v_k is constant per component, so strain rates are 0
  bool predicted;       ///< the active set is the predicted one: there is only one iteration
  bool refresh = true;  ///< rebuild the preconditioner's aggregates
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

/// Lower bounds of the references that a residual is compared with, see SolvePcg.
struct SolveFloor {
  double reference = 0;  ///< [N s]
  double scale = 0;      ///< [sqrt(J)] that of the solve which is repeated
  double accept = 0;     ///< see SolvePcg
  double gain = 0;       ///< see SolvePcg
};

/// The system (M - h^2 J) dv = b (P-Cloth eq. (3)) over all ranks: assembly and solution.
template <class T>
class LinearSystem {
 public:
  LinearSystem(Store<T>& store, std::vector<RankGeometry<T>>& geometry,
               std::vector<RankMotion<T>>& motion);

  /// Arrays of rank r that the caller fills before assemble().
  Buffer<Vec3<T>>& iterate_positions(int r) {
    return ranks_[static_cast<std::size_t>(r)].iterate_positions;
  }
  Buffer<Vec3<T>>& iterate_velocities(int r) {
    return ranks_[static_cast<std::size_t>(r)].iterate_velocities;
  }

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
  void launch_solve(const Linearisation& at, const SolveFloor& floor);

  /// [N s] 2-norm of the impulses of gravity on all cloth vertices in a step of length h
  double weight_impulse(double h) const { return h * weight_; }

  /// Saves v_k and dv for move_along(), before the system is assembled at another point.
  void begin_line();
  /// velocities_t1 of own rows = saved v_k + share times saved dv, on all ranks.
  void move_along(double share);
  /// Products of the assembled right-hand side with the saved dv. Waits for the ranks.
  ResidualProducts products();

  /// Energies of the motion from the state to positions_t1. Waits for the ranks.
  StepEnergy step_energy();
  /// The same for a motion that starts elsewhere.
  /// @param positions, velocities [ranks] of all vertices [m], [m/s]
  StepEnergy step_energy(const std::vector<Span<const Vec3<T>>>& positions,
                         const std::vector<Span<const Vec3<T>>>& velocities);
  /// Kinetic energy of the state. Waits for the ranks.
  /// @return [J]
  double kinetic_energy();

  /// Outcome of the latest solve. Waits for rank 0.
  SolveStatus status();

 private:
  struct Rank {
    // Elements that touch this rank's rows
    Buffer<Tri> triangles;
    Buffer<Mat2<T>> inv_rest;
    Buffer<T> area;
    Buffer<T> pressure;          ///< empty: none
    std::vector<Index> numbers;  ///< of the triangles, in the model
    Buffer<T> compression;       ///< resisted share of compression; empty: 1
    Buffer<Index> material;
    Buffer<MaterialRow<T>> materials;
    Buffer<T> material_tables;
    Buffer<Hinge> hinges;
    Buffer<T> hinge_stiffness, hinge_rest_angle, hinge_damping;
    Buffer<Vec3<T>> triangle_impulse;
    Buffer<Mat3<T>> triangle_block;
    Buffer<Mat3<T>> corner_drag;  ///< empty: no wind
    Buffer<Vec3<T>> hinge_direction;
    Buffer<T> hinge_impulse_scale, hinge_curvature;
    // Mesh part of the matrix
    Buffer<Offset> slice_offset;
    Buffer<Index> column;
    Buffer<T> value;
    Buffer<Mat3<T>> diagonal;
    Buffer<T> vertex_mass;        ///< see VertexPart
    Buffer<Mat3<T>> vertex_drag;  ///< empty: no wind
    Buffer<Offset> block_source_offset;
    Buffer<BlockSource> block_source;
    Buffer<Offset> corner_source_offset;
    Buffer<Index> corner_source;
    Buffer<Index> mesh_ghost;
    // Bending as a plate
    Buffer<Offset> in_pattern_offset, in_pattern_place, off_pattern_slice_offset;
    Buffer<Index> in_pattern_column, off_pattern_column;
    Buffer<T> in_pattern_stiffness, in_pattern_damping, off_pattern_stiffness, off_pattern_damping,
        off_pattern_value;
    // Curved rest shapes of plates
    Buffer<Tri> shape_corners;
    Buffer<Mat2<T>> shape_inv_rest;
    Buffer<Offset> shape_offset, shape_entry_offset, shape_corner_offset;
    Buffer<Index> shape_vertex, shape_entry_triangle, shape_entry, shape_corner;
    Buffer<Vec3<T>> shape_force, shape_axes, shape_corner_force;
    // Contact part
    Buffer<Spring<T>> springs;
    Buffer<Index> row_entry_count, row_entry;
    Buffer<Offset> contact_offset;  ///< this and the next two: host only
    Buffer<Index> contact_column;
    Buffer<T> contact_value;
    Buffer<ContactOperatorEntry<T>> link;  ///< this and the next three: CUDA only
    Buffer<Index> contact_entry_count;
    Buffer<ContactScatter<T>> contact_scatter;
    Buffer<ContactGather<T>> contact_gather;
    // Solver
    Buffer<Vec3<T>> iterate_positions, iterate_velocities;
    Buffer<Vec3<T>> mesh_rhs;  ///< without contacts
    Buffer<Vec3<T>> rhs;
    Buffer<Mat3<T>> inverse;
    Buffer<T> schwarz_inverse[schwarz_level_count];
    Buffer<Vec3<T>> x, u, r, w, p, s;
    Buffer<Vec3<T>> line_start, line_direction;  ///< of a line search; empty until there is one
    Buffer<double> line_partial;
    Buffer<StretchError<T>> stretch_error;  ///< this and the next: empty until they are asked for
    Buffer<double> energy_partial;
    Buffer<Vec3<T>> no_velocities;    ///< [vertices] zeros; empty until they are asked for
    Buffer<Index> held_always, held;  ///< [components] see SolveInitialGuess; empty: none falls
    Buffer<Index> stamp, ghost, ghost_offset;
    Buffer<double> partial;
    Buffer<std::uint32_t> ready, receivers;
    Buffer<SolveStatus> status;
    Buffer<SolvePcgPart<T>> parts;
    bool has_contacts = false;  ///< or springs
  };

  /// Contact data of a rank that an iteration reads.
  struct ContactCounts {
    Offset blocks = 0;  ///< of the matrix, on the host
    Index ends = 0;     ///< of the contact operator, on CUDA
    Index links = 0;    ///< of the contact operator, on CUDA

    double bytes() const {
      return static_cast<double>(blocks) * block_bytes<T> + ends * end_bytes<T> +
             links * link_bytes<T>;
    }
  };

  Index row_begin(int r) const { return store_.partition().row_begin[static_cast<std::size_t>(r)]; }
  Index row_count(int r) const { return row_begin(r + 1) - row_begin(r); }
  void make_elements(int r, const MeshRows& rows);
  void take_compression();
  void make_plate_part(int r, const MeshRows& rows);
  void make_shape_part(int r);
  void make_rank(int r);
  void make_ranks();
  /// Rows per reduction block of a solve.
  Index partial_rows() const;
  double mesh_work(int r) const;
  std::vector<double> contact_work(int r);
  void assemble_rank(int r, const Linearisation& at, Span<const Contact<T>> contacts);
  /// [cloth vertices] Positions at which elements are evaluated, and the velocities for their
  /// strain rates; empty: no rates.
  Span<const Vec3<T>> element_positions(int r, const Linearisation& at) const;
  Span<const Vec3<T>> element_rates(int r, const Linearisation& at) const;
  void assemble_elements(int r, const Linearisation& at);
  void assemble_plate(int r, const Linearisation& at);
  void assemble_contacts_of(int r, const Linearisation& at, Span<const Contact<T>> contacts);
  void note_pins(const std::vector<unsigned char>& fixed);
  void mark_held(int r, Span<const Contact<T>> contacts);
  void launch_initial_guess(int r, const Linearisation& at, Span<const Contact<T>> contacts);
  void assemble_contact_rows(int r, const Linearisation& at, Span<const Contact<T>> contacts);
  BlockEll<T> mesh_view(int r) const;
  ContactPart<T> contact_view(int r) const;
  ScalarEll<T> far_view(int r) const;
  SchwarzLevel<T> coarse_level(int r, int level) const;
  void make_preconditioner(int r);
  void launch_coarse(int r);
  SolvePcgPart<T> part(int r);
  TrackedRows tracked_rows(const Linearisation& at);
  double left_with_contacts(double h) const;
  bool all_fall() const;
  double fall_scale(double h) const;

  Store<T>& store_;
  std::vector<RankGeometry<T>>& geometry_;
  std::vector<RankMotion<T>>& motion_;
  std::vector<Rank> ranks_;
  std::shared_ptr<const PlateMatrix> plate_;  ///< source of the ranks' plate rows
  TrackedSystem* tracked_ = nullptr;
  std::vector<Index> component_of_vertex_;      ///< [cloth vertices]
  std::vector<Index> pinned_components_;        ///< [components] 1: has fixed vertices
  std::vector<Index> held_always_;              ///< [components] 1: these, or has springs
  bool can_fall_ = false;                       ///< gravity is all that acts from outside
  std::vector<ContactCounts> contact_counts_;   ///< [ranks] of the latest ask_row_work()
  std::uint64_t compression_epoch_ = 0;         ///< of the `compression` that the ranks hold
  Index halo_epoch_ = 0;                        ///< number of the latest ghost list
  std::uint32_t pcg_epoch_ = 0;                 ///< see SolvePcg::epoch
  double weight_ = 0;                           ///< [N] 2-norm of the weights of all cloth
  std::vector<SolvePcgPart<T>> parts_;          ///< host copy while it is uploaded
  std::optional<PipelinedSolve<T>> pipelined_;  ///< empty: the transport is peer
};

}  // namespace weft
