#include "host/implicit/row_sharing.hpp"

#include <chrono>
#include <utility>

#include "host/implicit/parallel/shared_work.hpp"

namespace weft {

BalanceReport& BalanceReport::operator+=(const BalanceReport& b) {
  rows += b.rows;
  box_tests += b.box_tests;
  pairs += b.pairs;
  ccd_tests += b.ccd_tests;
  queries += b.queries;
  rebalances += b.rebalances;
  seconds += b.seconds;
  if (b.rebalances > 0) {
    imbalance_before = b.imbalance_before;
    imbalance_after = b.imbalance_after;
  }
  return *this;
}

template <class T>
void RowSharing<T>::share(std::vector<Index> row_begin) {
  store_.share_rows(std::move(row_begin));
  for (int r = 0; r < store_.devices().size(); ++r)
    upload(store_.devices()[r].compute(), geometry_[static_cast<std::size_t>(r)].row_begin,
           store_.partition().row_begin);
  system_.share_rows();
}

template <class T>
void RowSharing<T>::rebalance(StepReport& report) {
  if (store_.devices().size() == 1 || !balance_.due()) return;
  const auto start = std::chrono::steady_clock::now();
  BalanceReport done;
  if (auto cut = balance_.cut(system_.partial_work(), store_.partition())) {
    share(std::move(cut->row_begin));
    done.rebalances = 1;
    done.imbalance_before = cut->imbalance_before;
    done.imbalance_after = cut->imbalance_after;
  }
  done.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  report.stages.other += done.seconds;
  report.balance += done;
}

template <class T>
void RowSharing<T>::count(int iterations, StepReport& report) {
  if (store_.devices().size() == 1 || iterations == 0) return;
  const std::vector<double> work = system_.row_work();
  balance_.add(work, iterations);
  const SharedWork an_iteration = shared_work(work);
  report.balance.rows += {iterations * an_iteration.busiest, iterations * an_iteration.even};
}

template class RowSharing<float>;
template class RowSharing<double>;

}  // namespace weft
