#include <algorithm>

#include "host/base/parallel.hpp"
#include "host/implicit/linear/linear_system.hpp"
#include "host/implicit/parallel/exchange.hpp"

namespace weft {
namespace {

/// Slots of each slice, as often as it has rows. [rows]
std::vector<double> slots_of_rows(const std::vector<Offset>& slice_offset, Index slice,
                                  std::size_t rows) {
  std::vector<double> slots;
  slots.reserve(rows);
  for (std::size_t i = 0; i < rows; ++i) {
    const std::size_t s = i / static_cast<std::size_t>(slice);
    slots.push_back(static_cast<double>(slice_offset[s + 1] - slice_offset[s]));
  }
  return slots;
}

}  // namespace

/// Bytes an iteration of rank r's rows without contacts.
template <class T>
double LinearSystem<T>::mesh_work(int r) const {
  const Rank& rank = ranks_[static_cast<std::size_t>(r)];
  return row_count(r) * row_bytes<T>(store_.scene().solver.preconditioner) +
         static_cast<double>(rank.column.size()) * block_bytes<T> +
         static_cast<double>(rank.off_pattern_column.size()) * scalar_bytes<T>;
}

template <class T>
void LinearSystem<T>::ask_row_work() {
  contact_counts_.assign(ranks_.size(), {});
  for (int r = 0; r < store_.devices().size(); ++r) {
    const Rank& rank = ranks_[static_cast<std::size_t>(r)];
    if (!rank.has_contacts) continue;
    ContactCounts& counts = contact_counts_[static_cast<std::size_t>(r)];
    Queue& queue = store_.devices()[r].compute();
    if (store_.devices().backend() == Backend::host) {
      queue.copy(&counts.blocks, rank.contact_offset.data() + row_count(r), sizeof(Offset));
      continue;
    }
    queue.copy(&counts.ends, rank.row_entry_count.data() + row_count(r), sizeof(Index));
    queue.copy(&counts.links, rank.contact_entry_count.data(), sizeof(Index));
  }
}

template <class T>
std::vector<double> LinearSystem<T>::row_work() const {
  std::vector<double> work;
  for (int r = 0; r < store_.devices().size(); ++r)
    work.push_back(mesh_work(r) + contact_counts_[static_cast<std::size_t>(r)].bytes());
  return work;
}

/// Bytes an iteration of the contacts in each row of rank r, which has some; links by their ends.
template <class T>
std::vector<double> LinearSystem<T>::contact_work(int r) {
  const Rank& rank = ranks_[static_cast<std::size_t>(r)];
  Queue& queue = store_.devices()[r].compute();
  std::vector<double> work;
  if (store_.devices().backend() == Backend::host) {
    work = slots_of_rows(download(queue, rank.contact_offset), 1, rank.contact_offset.size() - 1);
    for (double& bytes : work) bytes *= block_bytes<T>;
    return work;
  }
  const std::vector<Index> begin = download(queue, rank.row_entry_count);
  const double links = download(queue, rank.contact_entry_count).front();
  const double each = end_bytes<T> + link_bytes<T> * links / std::max<double>(begin.back(), 1);
  for (std::size_t i = 0; i + 1 < begin.size(); ++i)
    work.push_back((begin[i + 1] - begin[i]) * each);
  return work;
}

template <class T>
std::vector<double> LinearSystem<T>::partial_work() {
  sync_ranks(store_.devices());
  const Partition& partition = store_.partition();
  std::vector<double> work;
  for (int r = 0; r < store_.devices().size(); ++r) {
    const Rank& rank = ranks_[static_cast<std::size_t>(r)];
    Queue& queue = store_.devices()[r].compute();
    const auto rows = static_cast<std::size_t>(row_count(r));
    const std::vector<double> blocks =
        slots_of_rows(download(queue, rank.slice_offset), partition.slice, rows);
    std::vector<double> scalars(rows, 0);
    if (rank.off_pattern_column.size() > 0)
      scalars =
          slots_of_rows(download(queue, rank.off_pattern_slice_offset), partition.slice, rows);
    std::vector<double> contacts(rows, 0);
    if (rank.has_contacts) contacts = contact_work(r);
    for (std::size_t i = 0; i < rows; ++i) {
      if (i % static_cast<std::size_t>(partition.partial_rows) == 0) work.push_back(0);
      work.back() += row_bytes<T>(store_.scene().solver.preconditioner) +
                     blocks[i] * block_bytes<T> + contacts[i] + scalars[i] * scalar_bytes<T>;
    }
  }
  return work;
}

template <class T>
void LinearSystem<T>::share_rows() {
  sync_ranks(store_.devices());
  make_ranks();
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
  contact_counts_.assign(ranks, {});
  compression_epoch_ = 0;
  pipelined_.reset();
  if (choose_transport(store_.scene().solver, store_.devices()) == Transport::pipelined)
    pipelined_.emplace(store_.devices(), store_.partition().row_begin, partial_rows());
}

template double LinearSystem<float>::mesh_work(int) const;
template double LinearSystem<double>::mesh_work(int) const;
template void LinearSystem<float>::ask_row_work();
template void LinearSystem<double>::ask_row_work();
template std::vector<double> LinearSystem<float>::row_work() const;
template std::vector<double> LinearSystem<double>::row_work() const;
template std::vector<double> LinearSystem<float>::contact_work(int);
template std::vector<double> LinearSystem<double>::contact_work(int);
template std::vector<double> LinearSystem<float>::partial_work();
template std::vector<double> LinearSystem<double>::partial_work();
template void LinearSystem<float>::share_rows();
template void LinearSystem<double>::share_rows();
template void LinearSystem<float>::make_ranks();
template void LinearSystem<double>::make_ranks();

}  // namespace weft
