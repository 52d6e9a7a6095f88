#include "host/implicit/linear/contact_buffers.hpp"

#include <algorithm>

namespace weft {

template <class T>
void ContactBuffers<T>::make(Device& device, const RankRows& own) {
  const MemoryName name("matrix");
  any_ = false;
  const auto rows = static_cast<std::size_t>(own.count);
  weft::make(device, springs_, 0);
  weft::make(device, row_entry_count_, rows + 1);
  weft::make(device, row_entry_, 0);
  weft::make(device, link_, 0);
  weft::make(device, link_count_, 1);
  weft::make(device, scatter_, 0);
  weft::make(device, gather_, 0);
}

template <class T>
void ContactBuffers<T>::set_springs(Queue& queue, const std::vector<Spring<T>>& springs) {
  if (springs_.size() + springs.size() > 0) upload(queue, springs_, springs);
}

template <class T>
void ContactBuffers<T>::assemble(Queue& queue, const RankRows& own, const At& at) {
  any_ = !at.contacts.empty() || springs_.size() > 0;
  if (!any_) return;
  const std::size_t ends = 4 * at.contacts.size() + 2 * springs_.size();
  const std::size_t links = at.contacts.size() + springs_.size();
  if (row_entry_.size() < ends || scatter_.size() < ends || link_.size() < links) {
    // The arrays may still be in use by the solve before.
    queue.sync();
    row_entry_.grow(ends);
    scatter_.grow(ends);
    link_.grow(links);
    gather_.resize(link_.size());
  }
  launch(queue, AssembleContacts<T>{own.begin, own.count, at.cloth_vertex_count, at.contacts,
                                    springs_.span(), at.iterate_positions, at.positions, at.h,
                                    at.predicted, row_entry_count_.span(), row_entry_.span(),
                                    at.rhs, link_.span(), link_count_.span(), scatter_.span()});
}

template <class T>
ContactOperator<T> ContactBuffers<T>::view() const {
  if (!any_) return {};
  return {link_.span(), link_count_.span(), row_entry_count_.span(), scatter_.span(),
          gather_.span()};
}

template <class T>
void ContactBuffers<T>::ask_counts(Queue& queue, const RankRows& own, Counts& counts) const {
  if (!any_) return;
  queue.copy(&counts.ends, row_entry_count_.data() + own.count, sizeof(Index));
  queue.copy(&counts.links, link_count_.data(), sizeof(Index));
}

template <class T>
std::vector<double> ContactBuffers<T>::bytes_of_rows(Queue& queue) const {
  std::vector<double> work;
  if (!any_) return work;
  const std::vector<Index> begin = download(queue, row_entry_count_);
  const double links = download(queue, link_count_).front();
  const double each = end_bytes<T> + link_bytes<T> * links / std::max<double>(begin.back(), 1);
  for (std::size_t i = 0; i + 1 < begin.size(); ++i)
    work.push_back((begin[i + 1] - begin[i]) * each);
  return work;
}

template class ContactBuffers<float>;
template class ContactBuffers<double>;

}  // namespace weft
