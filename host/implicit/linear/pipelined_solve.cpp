#include "host/implicit/linear/pipelined_solve.hpp"

#include <cstddef>

namespace weft {
namespace {

/// Iterations that are under way before the host looks whether there have been enough. What is too
/// much costs the copies of an iteration each; looking costs the time in which nothing is under
/// way.
constexpr int batch = 8;

}  // namespace

Transport choose_transport(const SolverSettings& settings, const DeviceSet& devices) {
  if (settings.transport != Transport::automatic) return settings.transport;
  return !devices[0].reaches_peers() ? Transport::pipelined : Transport::peer;
}

template <class T>
PipelinedSolve<T>::PipelinedSolve(DeviceSet& devices, const std::vector<Index>& row_begin,
                                  Index partial_rows)
    : devices_(&devices), row_begin_(row_begin), ranks_(row_begin.size() - 1) {
  const std::vector<std::vector<Transfer>> queues = work_queues(ranks());
  for (int r = 0; r < ranks(); ++r) {
    const auto n = static_cast<std::size_t>(r);
    Rank& own = ranks_[n];
    own.queue = queues[n];
    own.arrival = Buffer<unsigned char>(devices[r], static_cast<std::size_t>(ranks()));
    own.group_stage = Buffer<unsigned char>(
        devices[r], static_cast<std::size_t>(pipelined_groups(row_begin[n + 1] - row_begin[n])));
    own.state = Buffer<PipelinedState<T>>(devices[r], 1);
    const auto first = static_cast<std::size_t>(pcg_partials(row_begin[n], partial_rows));
    const auto end = static_cast<std::size_t>(pcg_partials(row_begin[n + 1], partial_rows));
    partials_.push_back({3 * first, 3 * (end - first)});
  }
  gather_before_products(false);
}

template <class T>
void PipelinedSolve<T>::gather_before_products(bool gather) {
  gather_ = gather;
  for (int r = 0; r < ranks(); ++r) {
    const std::vector<unsigned char> none(static_cast<std::size_t>(ranks()), 0);
    const std::vector<unsigned char> arrival =
        gather ? none : arrival_stages(rank(r).queue, r, ranks());
    Queue& queue = (*devices_)[r].compute();
    queue.copy(rank(r).arrival.data(), arrival.data(), arrival.size());
    queue.sync();
  }
}

template <class T>
void PipelinedSolve<T>::launch_one(int r, PipelinedWork work, int stage) {
  SolvePipelined<T>& args = rank(r).args;
  args.work = work;
  args.stage = stage;
  args.only_if_running = only_if_running_;
  launch((*devices_)[r].compute(), args);
}

template <class T>
void PipelinedSolve<T>::launch_all(PipelinedWork work) {
  for (int r = 0; r < ranks(); ++r) launch_one(r, work);
}

/// Later transfers of every rank start after those of all ranks. By way of rank 0, which takes far
/// fewer waits than everybody waiting for everybody.
/// @param copied [ranks]
template <class T>
void PipelinedSolve<T>::join_transfers(const std::vector<Event>& copied) {
  Queue& hub = (*devices_)[0].transfer();
  for (int r = 1; r < ranks(); ++r) hub.wait(copied[static_cast<std::size_t>(r)]);
  const Event all = hub.record();
  for (int r = 1; r < ranks(); ++r) (*devices_)[r].transfer().wait(all);
}

/// What rank `r` receives in one stage of its queue.
template <class T>
void PipelinedSolve<T>::copy_vector(Span<Vec3<T>> SolvePcgPart<T>::*vector, int r,
                                    const Transfer& transfer) {
  const auto v = static_cast<std::size_t>(transfer.vector);
  const auto rows = static_cast<std::size_t>(row_begin_[v + 1] - row_begin_[v]);
  (*devices_)[r].transfer().copy((rank(r).args.part.*vector).data() + row_begin_[v],
                                 (rank(transfer.from).args.part.*vector).data() + row_begin_[v],
                                 rows * sizeof(Vec3<T>));
}

/// w = A vector on all ranks, of which each has its own rows so far.
template <class T>
void PipelinedSolve<T>::multiply(Span<Vec3<T>> SolvePcgPart<T>::*vector, PipelinedWork work) {
  std::vector<Event> ready;
  if (ranks() > 1)
    for (int r = 0; r < ranks(); ++r) ready.push_back((*devices_)[r].compute().record());
  if (!gather_) launch_all(work);
  // A rank's copies overwrite what its last product read, so they wait for its own work too. From
  // the second stage on all of this has been waited for.
  for (int r = 0; r < static_cast<int>(ready.size()); ++r)
    (*devices_)[r].transfer().wait(ready[static_cast<std::size_t>(r)]);
  const int stages = static_cast<int>(rank(0).queue.size());
  std::vector<Event> copied(ready.size());
  for (int stage = 1; stage <= stages; ++stage) {
    if (stage > 1) join_transfers(copied);
    for (int r = 0; r < ranks(); ++r) {
      const auto n = static_cast<std::size_t>(r);
      const Transfer& transfer = rank(r).queue[static_cast<std::size_t>(stage - 1)];
      Queue& queue = (*devices_)[r].transfer();
      if (transfer.any()) {
        if (stage == 1) queue.wait(ready[static_cast<std::size_t>(transfer.from)]);
        copy_vector(vector, r, transfer);
      }
      copied[n] = queue.record();
      if (!transfer.any() || gather_) continue;
      (*devices_)[r].compute().wait(copied[n]);
      launch_one(r, work, stage);
    }
  }
  if (!gather_) return;
  for (int r = 0; r < ranks(); ++r) {
    if (!copied.empty()) (*devices_)[r].compute().wait(copied[static_cast<std::size_t>(r)]);
    launch_one(r, work);
  }
}

/// All ranks' partial sums to all ranks, and from there into the scalars.
template <class T>
void PipelinedSolve<T>::reduce(PipelinedWork sums, PipelinedWork taken) {
  launch_all(sums);
  const auto partial = [&](int r) { return rank(r).args.part.partial.data(); };
  all_gather(
      *devices_, partials_, sizeof(double),
      [&](int r) { return partial(r) + partials_[static_cast<std::size_t>(r)].begin; }, partial);
  launch_all(taken);
}

/// The true residual and what follows from it. x of others is there once it has been multiplied.
template <class T>
void PipelinedSolve<T>::begin_recurrence(bool with_magnitude) {
  only_if_running_ = false;
  multiply(&SolvePcgPart<T>::x, PipelinedWork::multiply_x);
  launch_all(PipelinedWork::residual);
  if (with_magnitude) reduce(PipelinedWork::magnitudes, PipelinedWork::take_magnitude);
  multiply(&SolvePcgPart<T>::u, PipelinedWork::multiply_u);
  reduce(PipelinedWork::products, PipelinedWork::restart);
}

template <class T>
void PipelinedSolve<T>::iterate() {
  only_if_running_ = true;
  launch_all(PipelinedWork::update);
  multiply(&SolvePcgPart<T>::u, PipelinedWork::multiply_u);
  reduce(PipelinedWork::products, PipelinedWork::advance);
}

template <class T>
PipelinedState<T> PipelinedSolve<T>::state() {
  PipelinedState<T> state;
  Queue& queue = (*devices_)[0].compute();
  queue.copy(&state, rank(0).state.data(), sizeof state);
  queue.sync();
  return state;
}

template <class T>
void PipelinedSolve<T>::solve(const std::vector<SolvePcg<T>>& solves,
                              const std::vector<SolvePcgPart<T>>& parts) {
  for (int r = 0; r < ranks(); ++r) {
    const auto n = static_cast<std::size_t>(r);
    Rank& own = ranks_[n];
    own.args.solve = solves[n];
    own.args.part = parts[n];
    own.args.arrival = own.arrival.span();
    own.args.group_stage = own.group_stage.span();
    own.args.state = own.state.span();
  }
  only_if_running_ = false;
  launch_all(PipelinedWork::begin);
  PipelinedState<T> now;
  // PcgScalars bounds both restarts and iterations.
  bool running = solves.front().resume;
  while (now.over == 0) {
    if (!running) begin_recurrence(now.scalars.asks_for_magnitude());
    running = false;
    do {
      for (int k = 0; k < batch; ++k) iterate();
      now = state();
      if (devices_->stop_requested()) return;
    } while (now.scalars.running);
  }
}

template class PipelinedSolve<float>;
template class PipelinedSolve<double>;

}  // namespace weft
