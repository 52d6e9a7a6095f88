#include "host/implicit/linear/linear_system.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/base/parallel.hpp"
#include "host/implicit/parallel/exchange.hpp"
#include "weft/kernels/integrate/update.hpp"
#include "weft/kernels/solve/halo.hpp"
#include "weft/kernels/solve/initial_guess.hpp"

namespace weft {
namespace {

/// By how much of the contacts' thickness a solve may leave vertices away from where they belong,
/// root mean square over the cloth's mass. Where contacts press hard a share of the first residual
/// is more than that. Nor may velocities of several components of cloth be off by more than
/// `solver.tolerance` of what gravity adds in the step: where one is pulled fast from under
/// another, a share of what the pull leaves to solve for is more than all friction on the other.
/// While springs pull, what they leave is worth no such effort.
constexpr double misplaced_share = 0.05;

/// A solve pauses for its contacts if it may leave at most this share of what misplacement alone
/// allows: if it is to go on by less, a pause saves nothing. Nor does it where pins may pull a
/// cloth: what the pull leaves to solve for then hides what friction on the others is.
constexpr double pause_share_max = 0.5;

}  // namespace

template <class T>
LinearSystem<T>::LinearSystem(Store<T>& store, std::vector<RankGeometry<T>>& geometry,
                              std::vector<RankMotion<T>>& motion)
    : store_(store),
      geometry_(geometry),
      motion_(motion),
      ranks_(geometry.size()),
      plate_(store.plate(fixed_vertices(store.scene(), store.model(), store.time))),
      held_(store) {
  make_ranks();
}

template <class T>
void LinearSystem<T>::make_rank(int r) {
  Device& device = store_.devices()[r];
  Rank& k = rank(r);
  k.own = RankRows(store_.partition(), r);
  const MeshRows rows = make_mesh_rows(store_.model(), store_.partition(), r);
  k.elements.make(device, store_.scene(), store_.model(), rows);
  k.mesh.make(device, k.own, rows, blows(store_.scene().wind));
  k.plate.make(device, *plate_, rows, store_.partition(), r);
  k.contacts.make(device, k.own);
  k.preconditioner.make(device, k.own, store_.scene().solver.preconditioner,
                        store_.partition().partial_rows);
  const Index cloth = store_.model().cloth_vertex_count;
  k.krylov.make(device, k.own, cloth, store_.devices().size(), partial_rows());
  const MemoryName name("solver");
  make(device, k.iterate_positions, static_cast<std::size_t>(store_.model().vertex_count));
  make(device, k.iterate_velocities, static_cast<std::size_t>(cloth));
  k.moving_frame.make(device, cloth, geometry(r).component_inverse_mass.size());
}

/// All that the ranks hold of their rows, side by side: they have nothing in common.
template <class T>
void LinearSystem<T>::make_ranks() {
  const auto ranks = ranks_.size();
  const unsigned threads =
      std::min(static_cast<unsigned>(ranks),
               setup_threads(static_cast<std::size_t>(store_.model().cloth_vertex_count)));
  for_each_index(threads, ranks, [this](std::size_t n) {
    ranks_[n] = Rank{};
    make_rank(static_cast<int>(n));
  });
  held_.make_ranks();
  contact_counts_.assign(ranks, {});
  compression_epoch_ = 0;
  pipelined_.reset();
  if (choose_transport(store_.scene().solver, store_.devices()) == Transport::pipelined)
    pipelined_.emplace(store_.devices(), store_.partition().row_begin, partial_rows());
}

template <class T>
void LinearSystem<T>::share_rows() {
  sync_ranks(store_.devices());
  make_ranks();
}

template <class T>
void LinearSystem<T>::hold(const std::vector<unsigned char>& fixed) {
  held_.note_pins(fixed);
  std::shared_ptr<const PlateMatrix> plate = store_.plate(fixed);
  if (plate == plate_) return;
  plate_ = std::move(plate);
  // The arrays may still be in use by the last solve, on other ranks too.
  sync_ranks(store_.devices());
  for (int r = 0; r < store_.devices().size(); ++r)
    rank(r).plate.make(store_.devices()[r], *plate_,
                       make_mesh_rows(store_.model(), store_.partition(), r), store_.partition(),
                       r);
}

/// Brings the ranks up to what the store's model says of compression.
template <class T>
void LinearSystem<T>::take_compression() {
  if (compression_epoch_ == store_.compression_epoch()) return;
  compression_epoch_ = store_.compression_epoch();
  for (int r = 0; r < store_.devices().size(); ++r)
    rank(r).elements.take_compression(store_.devices()[r].compute(), store_.model().compression);
}

template <class T>
Index LinearSystem<T>::partial_rows() const {
  const bool plain = store_.scene().solver.preconditioner == Preconditioner::block_jacobi;
  return std::min(store_.partition().partial_rows,
                  plain ? pcg_plain_partial_rows_max : pcg_partial_rows_max);
}

template <class T>
void LinearSystem<T>::set_springs(const std::vector<Spring<T>>& springs) {
  held_.set_springs(springs);
  for (int r = 0; r < store_.devices().size(); ++r)
    rank(r).contacts.set_springs(store_.devices()[r].compute(), springs);
}

template <class T>
void LinearSystem<T>::assemble_rank(int r, const Linearisation& at,
                                    Span<const Contact<T>> contacts) {
  assemble_mesh(r, at);
  assemble_contacts_of(r, at, contacts);
  // Serves the step's later solves too: what changes by then hardly moves the aggregates.
  if (at.refresh)
    rank(r).preconditioner.launch_levels(store_.devices()[r].compute(), rank(r).own, matrix(r));
  launch_initial_guess(r, at, contacts);
}

template <class T>
void LinearSystem<T>::assemble_mesh(int r, const Linearisation& at) {
  Rank& k = rank(r);
  Queue& queue = store_.devices()[r].compute();
  Span<const Vec3<T>> positions = k.iterate_positions.span();
  if (at.moved) positions = k.moving_frame.positions.span();
  Span<const Vec3<T>> rates;
  if (!at.without_rates) rates = k.iterate_velocities.span();
  const auto h = static_cast<T>(at.h);
  const Scene& scene = store_.scene();
  k.elements.assemble(queue, scene.wind, store_.rank(r),
                      {positions, rates, k.iterate_velocities.span(), h});
  k.mesh.assemble(queue, k.own, geometry(r), k.elements,
                  {motion(r).base_velocities.span(), k.iterate_velocities.span(),
                   vec_cast<T>(scene.gravity), h, k.krylov.mesh_rhs.span()});
  k.plate.assemble(queue, k.own, k.mesh, positions, rates, h, k.krylov.mesh_rhs.span());
}

template <class T>
void LinearSystem<T>::assemble_contacts_of(int r, const Linearisation& at,
                                           Span<const Contact<T>> contacts) {
  Rank& k = rank(r);
  Queue& queue = store_.devices()[r].compute();
  queue.copy(k.krylov.rhs.data(), k.krylov.mesh_rhs.data(), k.krylov.rhs.size() * sizeof(Vec3<T>));
  k.contacts.assemble(
      queue, k.own,
      {store_.model().cloth_vertex_count, contacts, k.iterate_positions.span(),
       store_.rank(r).positions.span(), static_cast<T>(at.h), at.predicted, k.krylov.rhs.span()});
  k.preconditioner.launch_blocks(queue, k.own, matrix(r));
  launch(queue, SolveHalo<T>{r, geometry(r).row_begin.span(), k.plate.ghost.span(),
                             k.contacts.view(), k.krylov.stamp.span(), ++halo_epoch_,
                             k.krylov.ghost.span(), k.krylov.ghost_offset.span()});
}

template <class T>
typename PreconditionerBuffers<T>::Of LinearSystem<T>::matrix(int r) const {
  const Rank& k = rank(r);
  return {k.mesh.view(k.own), k.plate.view(k.own, {k.mesh.order.span()}), k.contacts.view(),
          geometry(r).fixed.span()};
}

template <class T>
void LinearSystem<T>::launch_initial_guess(int r, const Linearisation& at,
                                           Span<const Contact<T>> contacts) {
  Rank& k = rank(r);
  const RankGeometry<T>& g = geometry(r);
  RankMotion<T>& m = motion(r);
  Span<const Vec3<T>> start;
  Span<const Index> held;
  if (at.predicted) {
    start = at.moved ? k.moving_frame.velocities.span() : store_.rank(r).velocities.span();
    if (held_.can_fall()) held = held_.mark(r, g, contacts);
  }
  launch(store_.devices()[r].compute(),
         SolveInitialGuess<T>{k.own.begin, k.own.count, m.positions_t1.span(),
                              m.base_positions.span(), start, k.iterate_velocities.span(),
                              g.fixed.span(), static_cast<T>(at.h), k.krylov.x.span(), held,
                              g.component_of_vertex.span(), m.base_velocities.span(),
                              g.damping_mass.span(), vec_cast<T>(store_.scene().gravity)});
}

template <class T>
SolvePcgPart<T> LinearSystem<T>::part(int r) {
  const Rank& k = rank(r);
  SolvePcgPart<T> part;
  const auto of = matrix(r);
  part.mesh = of.mesh;
  part.far = of.far;
  part.contact = of.contact;
  part.fixed = of.fixed;
  part.vertex = k.mesh.vertex_part(k.own);
  part.inverse = k.preconditioner.blocks(k.own);
  part.fine = k.preconditioner.fine();
  part.wide = k.preconditioner.wide();
  k.krylov.fill(part);
  return part;
}

template <class T>
TrackedRows LinearSystem<T>::tracked_rows(const Linearisation& at) {
  Queue& queue = store_.devices()[0].compute();
  return tracked_->rows(download(queue, motion_.front().base_positions),
                        download(queue, ranks_.front().iterate_velocities), at.h);
}

/// Whether gravity is all that acts on the cloth of the assembled system.
template <class T>
bool LinearSystem<T>::all_fall() const {
  return !rank(0).contacts.any() && held_.all_fall();
}

/// What gravity does to all cloth in a step, in the preconditioned norm. [sqrt(J)]
template <class T>
double LinearSystem<T>::fall_scale(double h) const {
  return length(store_.scene().gravity) * h * std::sqrt(store_.model().whole.mass);
}

/// Most that a solve with contacts may leave in the preconditioned norm for vertices to be where
/// they belong. [sqrt(J)]
template <class T>
double LinearSystem<T>::misplaced_left(double h) const {
  return misplaced_share * contact_thickness(store_.scene().contact) / h *
         std::sqrt(store_.model().whole.mass);
}

/// Most that a solve with contacts may leave in the preconditioned norm. [sqrt(J)]
template <class T>
double LinearSystem<T>::left_with_contacts(double h) const {
  const Scene& scene = store_.scene();
  const double left = misplaced_left(h);
  const double fallen = scene.solver.tolerance * length(scene.gravity) * h;
  const bool several = geometry_[0].component_inverse_mass.size() > 1;
  if (!several || rank(0).contacts.spring_count() > 0 || !(fallen > 0)) return left;
  return std::min(left, fallen * std::sqrt(store_.model().whole.mass));
}

template <class T>
void LinearSystem<T>::launch_solve(const Linearisation& at, const SolveRules& rules) {
  DeviceSet& devices = store_.devices();
  const SolverSettings& settings = store_.scene().solver;
  // Uploads of the last solve's parts are done: its outcome has been waited for.
  parts_.clear();
  for (int r = 0; r < devices.size(); ++r) parts_.push_back(part(r));
  if (tracked_ != nullptr) parts_.front().tracked = tracked_rows(at);
  // The initial guess of cloth that falls has gravity in it, but the tolerance is still a share of
  // that.
  const bool falls = at.predicted && all_fall();
  const double reference_min =
      falls ? std::max(rules.reference, weight_impulse(at.h)) : rules.reference;
  // Contacts and springs are the same on all ranks.
  const double left_max = rank(0).contacts.any() ? left_with_contacts(at.h) : 0;
  const double misplaced = misplaced_left(at.h);
  const bool pauses = rules.pause_for_contacts && store_.scene().pins.empty() &&
                      left_max <= pause_share_max * misplaced;
  std::vector<SolvePcg<T>> solves;
  for (int r = 0; r < devices.size(); ++r) {
    const Rank& k = rank(r);
    solves.push_back({r,
                      k.krylov.parts.span(),
                      geometry(r).row_begin.span(),
                      partial_rows(),
                      pcg_epoch_,
                      settings.tolerance,
                      reference_min,
                      rules.scale,
                      left_max,
                      settings.max_iterations,
                      k.own.count,
                      settings.preconditioner != Preconditioner::block_jacobi,
                      k.contacts.any() && devices.backend() == Backend::cuda,
                      devices.stop_flag(),
                      rules.accept,
                      rules.gain,
                      falls ? fall_scale(at.h) : 0,
                      rules.keep,
                      rules.pause,
                      rules.resume,
                      pauses ? misplaced : 0});
  }
  if (pipelined_ && tracked_ == nullptr) {
    pipelined_->solve(solves, parts_);
  } else {
    for (int r = 0; r < devices.size(); ++r)
      devices[r].compute().copy(rank(r).krylov.parts.data(), parts_.data(),
                                parts_.size() * sizeof(SolvePcgPart<T>));
    join_ranks(devices);
    launch_collective(devices, solves);
  }
  for (int r = 0; r < devices.size(); ++r) {
    const Rank& k = rank(r);
    launch(devices[r].compute(),
           IntegrateUpdate<T>{k.own.begin, k.own.count, k.iterate_velocities.span(),
                              k.krylov.x.span(), T(1), motion(r).velocities_t1.span()});
  }
  pcg_epoch_ += pcg_epochs(settings.max_iterations);
}

template <class T>
void LinearSystem<T>::begin_line() {
  for (int r = 0; r < store_.devices().size(); ++r) {
    Rank& k = rank(r);
    k.line.begin(store_.devices()[r], k.own, store_.partition().partial_rows, k.iterate_velocities,
                 k.krylov.x);
  }
}

template <class T>
void LinearSystem<T>::move_along(double share) {
  for (int r = 0; r < store_.devices().size(); ++r)
    rank(r).line.move_along(store_.devices()[r].compute(), rank(r).own, static_cast<T>(share),
                            motion(r).velocities_t1.span());
}

template <class T>
ResidualProducts LinearSystem<T>::products() {
  DeviceSet& devices = store_.devices();
  std::vector<std::vector<double>> partials(ranks_.size());
  for (int r = 0; r < devices.size(); ++r)
    rank(r).line.launch_products(devices[r].compute(), rank(r).own, store_.partition().partial_rows,
                                 rank(r).krylov.rhs.span(), geometry(r).fixed.span(),
                                 partials[static_cast<std::size_t>(r)]);
  sync_ranks(devices);
  ResidualProducts sum;
  for (const auto& of_rank : partials)
    for (std::size_t k = 0; k < of_rank.size(); k += 2) {
      sum.slope += of_rank[k];
      sum.residual += of_rank[k + 1];
    }
  sum.residual = std::sqrt(sum.residual);
  return sum;
}

template <class T>
StepEnergy LinearSystem<T>::step_energy() {
  return step_energy(Linearisation{});
}

template <class T>
StepEnergy LinearSystem<T>::step_energy(const Linearisation& at) {
  std::vector<Span<const Vec3<T>>> positions, velocities;
  for (int r = 0; r < store_.devices().size(); ++r) {
    positions.push_back(at.moved ? rank(r).moving_frame.positions.span()
                                 : store_.rank(r).positions.span());
    velocities.push_back(store_.rank(r).velocities.span());
  }
  return step_energy(positions, velocities);
}

template <class T>
StepEnergy LinearSystem<T>::step_energy(const std::vector<Span<const Vec3<T>>>& positions,
                                        const std::vector<Span<const Vec3<T>>>& velocities) {
  DeviceSet& devices = store_.devices();
  std::vector<std::vector<double>> partials(ranks_.size());
  for (int r = 0; r < devices.size(); ++r) {
    const auto n = static_cast<std::size_t>(r);
    Rank& k = ranks_[n];
    k.energy.launch_sums(devices[r], k.own, store_.partition().partial_rows, geometry_[n],
                         k.elements, k.mesh, positions[n], velocities[n],
                         motion_[n].positions_t1.span(), partials[n]);
  }
  sync_ranks(devices);
  StepEnergy sum;
  for (const auto& of_rank : partials)
    for (std::size_t k = 0; k < of_rank.size(); k += 3) {
      sum.at_start += of_rank[k];
      sum.turned += of_rank[k + 1];
      sum.limited += of_rank[k + 2];
    }
  return sum;
}

template <class T>
double LinearSystem<T>::kinetic_energy() {
  std::vector<Span<const Vec3<T>>> positions, velocities;
  for (int r = 0; r < store_.devices().size(); ++r) {
    const RankState<T>& state = store_.rank(r);
    positions.push_back(state.positions.span());
    velocities.push_back(rank(r).energy.zeros(store_.devices()[r], state.velocities.size()));
  }
  return step_energy().at_start - step_energy(positions, velocities).at_start;
}

template <class T>
SolveStatus LinearSystem<T>::status() {
  SolveStatus status;
  Queue& queue = store_.devices()[0].compute();
  queue.copy(&status, rank(0).krylov.status.data(), sizeof status);
  queue.copy(&turned_, rank(0).moving_frame.turned.data(), sizeof turned_);
  queue.sync();
  return status;
}

template <class T>
void LinearSystem<T>::ask_row_work() {
  contact_counts_.assign(ranks_.size(), {});
  for (int r = 0; r < store_.devices().size(); ++r)
    rank(r).contacts.ask_counts(store_.devices()[r].compute(), rank(r).own,
                                contact_counts_[static_cast<std::size_t>(r)]);
}

template <class T>
std::vector<double> LinearSystem<T>::row_work() const {
  const double each = row_bytes<T>(store_.scene().solver.preconditioner);
  std::vector<double> work;
  for (int r = 0; r < store_.devices().size(); ++r) {
    const Rank& k = rank(r);
    const double mesh = k.own.count * each +
                        static_cast<double>(k.mesh.column.size()) * block_bytes<T> +
                        static_cast<double>(k.plate.off_pattern_column.size()) * scalar_bytes<T>;
    work.push_back(mesh + contact_counts_[static_cast<std::size_t>(r)].bytes());
  }
  return work;
}

template <class T>
std::vector<double> LinearSystem<T>::partial_work() {
  sync_ranks(store_.devices());
  const Partition& partition = store_.partition();
  const double each = row_bytes<T>(store_.scene().solver.preconditioner);
  std::vector<double> work;
  for (int r = 0; r < store_.devices().size(); ++r) {
    const Rank& k = rank(r);
    Queue& queue = store_.devices()[r].compute();
    const auto rows = static_cast<std::size_t>(k.own.count);
    const std::vector<Index> packed = download(queue, k.mesh.order);
    const RowOrder order{packed};
    const std::vector<double> blocks =
        slots_of_rows(download(queue, k.mesh.slice_offset), order, partition.slice, rows);
    std::vector<double> scalars(rows, 0);
    if (k.plate.off_pattern_column.size() > 0)
      scalars = slots_of_rows(download(queue, k.plate.off_pattern_slice_offset), order,
                              partition.slice, rows);
    std::vector<double> contacts = k.contacts.bytes_of_rows(queue);
    contacts.resize(rows, 0);
    for (std::size_t i = 0; i < rows; ++i) {
      if (i % static_cast<std::size_t>(partition.partial_rows) == 0) work.push_back(0);
      work.back() += each + blocks[i] * block_bytes<T> + contacts[i] + scalars[i] * scalar_bytes<T>;
    }
  }
  return work;
}

template class LinearSystem<float>;
template class LinearSystem<double>;

}  // namespace weft
