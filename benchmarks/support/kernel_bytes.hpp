#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <typeindex>
#include <vector>

#include "weft/kernels/assemble/active_set_update.hpp"
#include "weft/kernels/assemble/bending.hpp"
#include "weft/kernels/assemble/contact_cache.hpp"
#include "weft/kernels/assemble/contacts.hpp"
#include "weft/kernels/assemble/membrane.hpp"
#include "weft/kernels/assemble/plate.hpp"
#include "weft/kernels/assemble/rows.hpp"
#include "weft/kernels/collide/boxes.hpp"
#include "weft/kernels/collide/candidate_update.hpp"
#include "weft/kernels/collide/continuous.hpp"
#include "weft/kernels/collide/grid.hpp"
#include "weft/kernels/collide/out_of_bounds.hpp"
#include "weft/kernels/collide/pairs.hpp"
#include "weft/kernels/collide/proximity.hpp"
#include "weft/kernels/collide/work.hpp"
#include "weft/kernels/integrate/advance.hpp"
#include "weft/kernels/integrate/history.hpp"
#include "weft/kernels/integrate/prescribe.hpp"
#include "weft/kernels/integrate/rate.hpp"
#include "weft/kernels/integrate/update.hpp"
#include "weft/kernels/respond/apply.hpp"
#include "weft/kernels/respond/remember.hpp"
#include "weft/kernels/respond/zones.hpp"
#include "weft/kernels/solve/halo.hpp"
#include "weft/kernels/solve/initial_guess.hpp"
#include "weft/kernels/solve/pcg.hpp"
#include "weft/kernels/solve/precondition.hpp"
#include "weft/kernels/solve/products.hpp"
#include "weft/kernels/solve/schwarz_levels.hpp"

namespace weft::bench {

/// Bytes that a launch cannot do without: every number that it needs read once from memory and
/// every number that it leaves written once, padding of matrices included. What is read again, or
/// passed between the kernels of one launch, is not counted. Counts that only the device knows -
/// pairs, entries, iterations - are read from there: to be asked after the launch, on one rank.
class KernelBytes {
 public:
  /// @param cloth_vertices of the scene, without obstacles
  explicit KernelBytes(Index cloth_vertices) : cloth_(cloth_vertices) {}

  /// Name of a kernel, "assemble/rows", and the bytes of a launch.
  struct Launch {
    const char* name;
    double bytes;
  };
  /// @param kernel, args as LaunchObserver::after() gets them
  /// @return        nothing for kernels that are not in the table
  std::optional<Launch> operator()(Queue& queue, const std::type_info& kernel, const void* args) {
    static const std::vector<Row> table = make_table();
    for (const Row& row : table)
      if (row.kernel == kernel) {
        queue_ = &queue;
        return Launch{row.name, row.bytes(*this, args)};
      }
    return {};
  }

 private:
  struct Row {
    std::type_index kernel;
    const char* name;
    double (*bytes)(const KernelBytes&, const void*);
  };
  template <class Args>
  static Row row(const char* name) {
    return {typeid(Args), name, [](const KernelBytes& of, const void* args) {
              return of.bytes(*static_cast<const Args*>(args));
            }};
  }
  template <class T>
  static void add_rows(std::vector<Row>& table) {
    const Row rows[] = {row<AssembleMembrane<T>>("assemble/membrane"),
                        row<AssembleBending<T>>("assemble/bending"),
                        row<AssembleRows<T>>("assemble/rows"),
                        row<AssemblePlate<T>>("assemble/plate"),
                        row<AssembleContacts<T>>("assemble/contacts"),
                        row<AssembleActiveSetUpdate<T>>("assemble/active_set_update"),
                        row<AssembleContactCache<T>>("assemble/contact_cache"),
                        row<Precondition<T>>("solve/precondition"),
                        row<SolveSchwarzLevels<T>>("solve/schwarz_levels"),
                        row<SolveInitialGuess<T>>("solve/initial_guess"),
                        row<SolvePcg<T>>("solve/pcg"),
                        row<SolveHalo<T>>("solve/halo"),
                        row<SolveProducts<T>>("solve/products"),
                        row<CollideBoxes<T>>("collide/boxes"),
                        row<CollideWork<T>>("collide/work"),
                        row<CollidePairs<T>>("collide/pairs"),
                        row<CollideProximity<T>>("collide/proximity"),
                        row<CollideContinuous<T>>("collide/continuous"),
                        row<CollideOutOfBounds<T>>("collide/out_of_bounds"),
                        row<CollideCandidateUpdate<T>>("collide/candidate_update"),
                        row<IntegrateAdvance<T>>("integrate/advance"),
                        row<RespondApply<T>>("respond/apply"),
                        row<RespondRemember>("respond/remember"),
                        row<IntegrateHistory<T>>("integrate/history"),
                        row<IntegratePrescribe<T>>("integrate/prescribe"),
                        row<IntegrateRate<T>>("integrate/rate"),
                        row<IntegrateUpdate<T>>("integrate/update"),
                        row<RespondZones<T>>("respond/zones")};
    table.insert(table.end(), std::begin(rows), std::end(rows));
  }
  static std::vector<Row> make_table() {
    std::vector<Row> table = {row<CollideGrid>("collide/grid")};
    add_rows<float>(table);
    add_rows<double>(table);
    return table;
  }

  // ---------------------------------------------------------------------------------- what is read
  /// A number in the device's memory.
  template <class V>
  V read(const V* number) const {
    V value{};
    queue_->copy(&value, number, sizeof value);
    queue_->sync();
    return value;
  }
  template <class... V>
  static double all(const Span<V>&... spans) {
    return (0.0 + ... + static_cast<double>(spans.size() * sizeof(V)));
  }
  template <class V>
  static double times(double count) {
    return count * static_cast<double>(sizeof(V));
  }
  /// Cloth's part of a vector; nothing if it is not there.
  template <class V>
  double cloth(const Span<V>& vector) const {
    return vector.empty() ? 0 : times<V>(cloth_);
  }
  /// Entries of a matrix, padding included.
  template <class Matrix>
  double entries(const Matrix& m) const {
    if (m.row_count == 0) return 0;
    const Index slices = (m.row_count + m.slice - 1) / m.slice;
    return static_cast<double>(read(m.slice_offset.data() + slices)) * m.slice;
  }
  template <class T>
  double matrix(const BlockEll<T>& m) const {
    if (m.row_count == 0) return 0;
    double loaded = entries(m);
    if (!m.order.packed.empty()) {  // CUDA: without padding
      std::vector<Index> packed(m.order.packed.size());
      queue_->copy(packed.data(), m.order.packed.data(), packed.size() * sizeof(Index));
      queue_->sync();
      const RowOrder order{packed};
      loaded = 0;
      for (Index place = 0; place < m.row_count; ++place) loaded += order.entries(place, 0);
    }
    return all(m.slice_offset, m.order.packed) + loaded * (9 * sizeof(T) + sizeof(Index));
  }
  template <class T>
  double matrix(const ScalarEll<T>& m) const {
    return m.row_count == 0 ? 0 : all(m.slice_offset) + entries(m) * (sizeof(T) + sizeof(Index));
  }
  template <class T>
  double system(const BlockEll<T>& mesh, const ScalarEll<T>& far,
                const ContactOperator<T>& contact) const {
    return all(mesh.diagonal) + product(mesh, far, contact);
  }
  /// What a product reads of the system.
  template <class T>
  double product(const BlockEll<T>& mesh, const ScalarEll<T>& far,
                 const ContactOperator<T>& contact) const {
    return matrix(mesh) + matrix(far) + links(contact);
  }
  template <class T>
  double links(const ContactOperator<T>& a) const {
    if (a.count.empty()) return 0;
    return times<ContactOperatorEntry<T>>(read(a.count.data())) + all(a.end_offset) +
           times<ContactScatter<T>>(read(a.end_offset.data() + a.end_offset.size() - 1));
  }
  /// What a product with links writes and reads besides.
  template <class T>
  double pulls(const ContactOperator<T>& a) const {
    return a.count.empty() ? 0 : 2 * times<ContactGather<T>>(read(a.count.data()));
  }

  // ------------------------------------------------------------------------------------- assemble
  template <class T>
  double bytes(const AssembleMembrane<T>& a) const {
    return all(a.triangles, a.inv_rest, a.area, a.material, a.materials, a.compression, a.impulse,
               a.block) +
           cloth(a.positions) + cloth(a.velocities);
  }
  template <class T>
  double bytes(const AssembleBending<T>& a) const {
    if (a.hinges.empty()) return 0;
    return all(a.hinges, a.stiffness, a.rest_angle, a.damping, a.direction, a.impulse_scale,
               a.curvature) +
           cloth(a.positions) + cloth(a.velocities);
  }
  template <class T>
  double bytes(const AssembleRows<T>& a) const {
    return all(a.block_source_offset, a.block_source, a.corner_source_offset, a.corner_source,
               a.triangle_block, a.triangle_impulse, a.hinge_direction, a.hinge_impulse_scale,
               a.hinge_curvature, a.matrix.slice_offset, a.matrix.value, a.matrix.diagonal, a.rhs,
               a.vertex_mass, a.corner_drag, a.vertex_drag.value) +
           cloth(a.mass) + cloth(a.damping_mass) + cloth(a.base_velocities) + cloth(a.velocities);
  }
  template <class T>
  double bytes(const AssemblePlate<T>& a) const {
    // Of a near entry's block the diagonal is read and written, and so is that of the row's own.
    return all(a.in_pattern_offset, a.in_pattern_place, a.in_pattern_column, a.in_pattern_stiffness,
               a.in_pattern_damping, a.off_pattern_slice_offset, a.off_pattern_column,
               a.off_pattern_stiffness, a.off_pattern_damping, a.off_pattern_value) +
           times<T>(6.0 * static_cast<double>(a.in_pattern_column.size() + a.diagonal.size())) +
           cloth(a.positions) + cloth(a.velocities) + 2 * all(a.rhs);
  }
  /// Vectors at the corners of so many contacts: no vertex is counted twice.
  template <class T>
  double corners(double contacts) const {
    return times<Vec3<T>>(std::min<double>(4 * contacts, cloth_));
  }
  template <class T>
  double bytes(const AssembleContacts<T>& a) const {
    const auto count = static_cast<double>(a.contacts.size() + a.springs.size());
    return all(a.contacts, a.springs, a.row_entry_count) + 2 * corners<T>(count) +
           times<Index>(4 * count) + 2 * corners<T>(count) + times<ContactOperatorEntry<T>>(count) +
           times<ContactScatter<T>>(4 * count);
  }
  template <class T>
  double bytes(const AssembleActiveSetUpdate<T>& a) const {
    const auto count = static_cast<double>(a.contacts.size());
    return all(a.contacts) + times<T>(6 * count) + times<Index>(2 * count) + 2 * corners<T>(count) +
           all(a.touched);
  }
  template <class T>
  double bytes(const AssembleContactCache<T>& a) const {
    return all(a.contacts, a.memory, a.touched) +
           2 * corners<T>(static_cast<double>(a.contacts.size()));
  }

  // ---------------------------------------------------------------------------------------- solve
  template <class T>
  double bytes(const Precondition<T>& a) const {
    return all(a.diagonal, a.inverse.value) + cloth(a.fixed) + links(a.contact);
  }
  template <class T>
  double bytes(const SolveSchwarzLevels<T>& a) const {
    return system(a.mesh, a.far, a.contact) + cloth(a.fixed) + all(a.fine.inverse, a.wide.inverse);
  }
  template <class T>
  double bytes(const SolveInitialGuess<T>& a) const {
    return cloth(a.start_velocities) + cloth(a.velocities) + cloth(a.fixed) + cloth(a.x);
  }
  template <class T>
  double bytes(const SolvePcg<T>& a) const {
    const SolvePcgPart<T> part = read(a.parts.data() + a.rank);
    const auto iterations = static_cast<double>(read(part.status.data()).iterations);
    const double product = this->product(part.mesh, part.far, part.contact) + pulls(part.contact) +
                           all(part.vertex.mass, part.vertex.drag.value);
    // As the comment of PcgBlock counts them: w; p, s, r, x and u of the update and of the
    // products; block Jacobi; marks.
    double vectors = cloth_ * ((3 + 18 + 15 + 6 + 9) * sizeof(T) + 2.0);
    vectors += all(part.fine.inverse, part.wide.inverse);
    // The residuals of the initial guess and of the outcome take a product more.
    return (iterations + 2) * (product + vectors) + 2 * product;
  }
  template <class T>
  double bytes(const SolveProducts<T>& a) const {
    return all(a.residual, a.partial) + cloth(a.direction) + cloth(a.fixed);
  }
  template <class T>
  double bytes(const SolveHalo<T>& a) const {
    if (a.row_begin.size() <= 2) return 0;  // a single rank has none
    const ContactOperator<T>& links = a.contact;
    return all(a.mesh_ghost) +
           times<Index>(links.count.empty() ? 0 : 4.0 * read(links.count.data()));
  }

  // -------------------------------------------------------------------------------------- collide
  /// What the broad phase keeps of some kinds of primitives.
  template <class T>
  double lists(const ClusterList<T>* of, bool split, bool obstacles, int first_kind) const {
    double sum = 0;
    for (int kind = first_kind; kind < cluster_kinds; ++kind) {
      if (kind % 2 == 1 && !obstacles) continue;
      sum += all(of[kind].clusters, of[kind].groups, of[kind].hulls);
      if (split) sum += all(of[kind].ends, of[kind].group_ends);
    }
    return sum;
  }
  template <class T>
  double bytes(const CollideBoxes<T>& a) const {
    const bool obstacles = read(a.obstacles_made.data()) != 0;
    double sum = all(a.positions_t0, a.positions_t1, a.edges, a.triangles, a.swept_aabb) +
                 lists(a.lists, read(a.split.data()) != 0, obstacles, 0);
    if (a.change_time > T(0)) sum += cloth(a.velocities) + cloth(a.previous_velocities);
    return sum;
  }
  double bytes(const CollideGrid& a) const {
    if (!a.wanted.empty() && read(a.wanted.data()) == 0) return 0;
    const Index used = read(a.bucket_offset.data() + a.bucket_offset.size() - 1);
    return all(a.boxes, a.bucket_offset) + times<GridEntry>(used);
  }
  double grids(const Grid* of) const {
    double sum = 0;
    for (int kind = cloth_faces; kind < cluster_kinds; ++kind) sum += all(of[kind].bucket_offset);
    return sum;
  }
  template <class T>
  double bytes(const CollideWork<T>& a) const {
    double sum = all(a.face_work, a.edge_work) + grids(a.grids);
    for (const ClusterList<T>& list : a.lists) sum += all(list.hulls);
    return sum;
  }
  template <class T>
  double bytes(const CollidePairs<T>& a) const {
    const CollideCounts counts = read(a.counts.data());
    double entries = 0;
    for (int kind = cloth_faces; kind < cluster_kinds; ++kind)
      entries += read(a.grids[kind].bucket_offset.data() + a.grids[kind].bucket_offset.size() - 1);
    return all(a.edges, a.triangles, a.face_work, a.edge_work) + grids(a.grids) +
           times<GridEntry>(entries) +
           lists(a.lists, !a.split.empty() && read(a.split.data()) != 0, true, 0) +
           times<Pair>(listed(counts.face_pairs, a.face_pairs.size()) +
                       listed(counts.edge_pairs, a.edge_pairs.size()));
  }
  static double listed(Index found, std::size_t capacity) {
    return std::min(static_cast<double>(found), static_cast<double>(capacity));
  }
  template <class T>
  double bytes(const CollideProximity<T>& a) const {
    const CollideCounts counts = read(a.counts.data());
    const double pairs = double(counts.face_pairs) + double(counts.edge_pairs);
    if (counts.out_of_bounds != 0 || counts.face_pairs > static_cast<Index>(a.face_pairs.size()) ||
        counts.edge_pairs > static_cast<Index>(a.edge_pairs.size()))
      return sizeof counts;
    // Corners, positions and separation bounds of all pairs; of contacts what they are and were.
    return pairs * (sizeof(Pair) + sizeof(float)) + all(a.surface.edges, a.triangles) +
           all(a.positions_t0, a.positions_t1) +
           times<Contact<T>>(listed(counts.contacts, a.contacts.size())) +
           all(a.face_memory, a.edge_memory);
  }
  template <class T>
  double bytes(const CollideContinuous<T>& a) const {
    const CollideCounts counts = read(a.counts.data());
    const double pairs = double(counts.face_pairs) + double(counts.edge_pairs);
    const double sum = pairs * sizeof(Pair) + all(a.edges, a.triangles, a.positions_t1) +
                       times<BoxOf<T>>(a.vertex_end - a.vertex_begin) +
                       times<Collision>(listed(counts.collisions, a.collisions.size()));
    // In later rounds pairs are chosen by their vertices, in the first by separation bounds.
    if (!a.moved.empty()) return sum + all(a.moved);
    return sum + pairs * sizeof(float) + all(a.predicted, a.deviation, a.positions_t0);
  }
  template <class T>
  double bytes(const CollideOutOfBounds<T>& a) const {
    return (a.vertex_end - a.vertex_begin) * (2.0 * sizeof(Vec3<T>) + sizeof(BoxOf<T>));
  }
  template <class T>
  double bytes(const CollideCandidateUpdate<T>& a) const {
    const CollideBoxes<T>& b = a.boxes;
    return all(b.positions_t0, b.positions_t1, b.edges, b.triangles, b.swept_aabb,
               a.out_of_bounds_index) +
           lists(b.lists, read(b.split.data()) != 0, false, 0);
  }

  // -------------------------------------------------------------------------------------- respond
  template <class T>
  double bytes(const IntegrateAdvance<T>& a) const {
    return cloth(a.base) + cloth(a.velocities) + cloth(a.fixed) + cloth(a.positions);
  }
  template <class T>
  double bytes(const RespondApply<T>& a) const {
    return all(a.moved) + static_cast<double>(a.moved.size()) * (3.0 * sizeof(Vec3<T>) + 2.0);
  }
  double bytes(const RespondRemember& a) const {
    return all(a.moved, a.crushed, a.crushed_in_jam) + 2 * all(a.touched);
  }
  template <class T>
  double bytes(const IntegrateHistory<T>& a) const {
    return all(a.base_positions, a.base_velocities) + cloth(a.positions) + cloth(a.velocities) +
           cloth(a.previous_positions) + cloth(a.previous_velocities) + cloth(a.touched);
  }
  template <class T>
  double bytes(const IntegratePrescribe<T>& a) const {
    return all(a.targets) + times<Vec3<T>>(static_cast<double>(a.targets.size()));
  }
  template <class T>
  double bytes(const IntegrateRate<T>& a) const {
    return cloth(a.positions) + cloth(a.base) + cloth(a.velocities);
  }
  template <class T>
  double bytes(const IntegrateUpdate<T>& a) const {
    return cloth(a.iterate) + cloth(a.dv) + cloth(a.velocities);
  }
  template <class T>
  double bytes(const RespondZones<T>& a) const {
    return all(a.collisions, a.zone_begin, a.multipliers, a.multipliers, a.moved, a.outcomes) +
           2 * corners<T>(static_cast<double>(a.collisions.size()));
  }

  double cloth_;
  Queue* queue_ = nullptr;
};

}  // namespace weft::bench
