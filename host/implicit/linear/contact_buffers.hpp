#pragma once

#include <vector>

#include "host/implicit/linear/iteration_bytes.hpp"
#include "host/implicit/linear/rank_rows.hpp"
#include "weft/kernels/assemble/contacts.hpp"
#include "weft/state/contact.hpp"

namespace weft {

/// Contacts and springs in a rank's rows: a ContactOperator.
template <class T>
class ContactBuffers {
 public:
  void make(Device& device, const RankRows& own);

  void set_springs(Queue& queue, const std::vector<Spring<T>>& springs);
  std::size_t spring_count() const { return springs_.size(); }

  /// The system that contacts and springs are added to. Spans are in the memory of the rank.
  struct At {
    Index cloth_vertex_count;
    Span<const Contact<T>> contacts;                   ///< all
    Span<const Vec3<T>> iterate_positions, positions;  ///< [m] iterate, and start of the step
    T h;                                               ///< [s]
    bool predicted;                                    ///< see Linearisation
    Span<Vec3<T>> rhs;                                 ///< [rows] [N s]
  };
  /// May wait for the queue.
  void assemble(Queue& queue, const RankRows& own, const At& at);

  /// Whether the latest assembly had contacts or springs.
  bool any() const noexcept { return any_; }
  ContactOperator<T> view() const;

  /// Sizes of the data that an iteration reads.
  struct Counts {
    Index ends = 0, links = 0;

    double bytes() const { return ends * end_bytes<T> + links * link_bytes<T>; }
  };
  /// Submits a copy of the counts.
  void ask_counts(Queue& queue, const RankRows& own, Counts& counts) const;
  /// Bytes that an iteration reads in each row; those of links are shared among their rows. Waits
  /// for the queue.
  /// @return [rows] empty if there are no contacts
  std::vector<double> bytes_of_rows(Queue& queue) const;

 private:
  bool any_ = false;
  Buffer<Spring<T>> springs_;
  Buffer<Index> row_entry_count_, row_entry_;
  Buffer<ContactOperatorEntry<T>> link_;
  Buffer<Index> link_count_;
  Buffer<ContactScatter<T>> scatter_;
  Buffer<ContactGather<T>> gather_;
};

}  // namespace weft
