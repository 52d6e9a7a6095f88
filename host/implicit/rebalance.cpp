#include <chrono>
#include <utility>

#include "host/implicit/parallel/shared_work.hpp"
#include "host/implicit/step.hpp"

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
void ImplicitStep<T>::share_rows(std::vector<Index> row_begin) {
  store_.share_rows(std::move(row_begin));
  for (int r = 0; r < store_.devices().size(); ++r)
    upload(store_.devices()[r].compute(), geometry_[static_cast<std::size_t>(r)].row_begin,
           store_.partition().row_begin);
  system_.share_rows();
}

/// Gives the ranks other rows if that is due by what earlier steps have cost.
template <class T>
void ImplicitStep<T>::rebalance(StepReport& report) {
  if (store_.devices().size() == 1 || !row_balance_.due()) return;
  const auto start = std::chrono::steady_clock::now();
  BalanceReport done;
  if (auto cut = row_balance_.cut(system_.partial_work(), store_.partition())) {
    share_rows(std::move(cut->row_begin));
    done.rebalances = 1;
    done.imbalance_before = cut->imbalance_before;
    done.imbalance_after = cut->imbalance_after;
  }
  done.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  report.stages.other += done.seconds;
  report.balance += done;
}

/// Solves of this attempt have been waited for.
template <class T>
void ImplicitStep<T>::count_rows(int iterations, StepReport& report) {
  if (store_.devices().size() == 1 || iterations == 0) return;
  const std::vector<double> work = system_.row_work();
  row_balance_.add(work, iterations);
  const SharedWork an_iteration = shared_work(work);
  report.balance.rows += {iterations * an_iteration.busiest, iterations * an_iteration.even};
}

template void ImplicitStep<float>::share_rows(std::vector<Index>);
template void ImplicitStep<double>::share_rows(std::vector<Index>);
template void ImplicitStep<float>::rebalance(StepReport&);
template void ImplicitStep<double>::rebalance(StepReport&);
template void ImplicitStep<float>::count_rows(int, StepReport&);
template void ImplicitStep<double>::count_rows(int, StepReport&);

}  // namespace weft
