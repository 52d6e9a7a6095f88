#include "host/asynchronous/workers.hpp"

#include <algorithm>

#include "weft/exec/spin.hpp"

namespace weft {

Workers::Workers(int count)
    : calls_(new Call[static_cast<std::size_t>(std::max(count, 1))]),
      thrown_(static_cast<std::size_t>(std::max(count, 1))) {
  for (int n = 1; n < count; ++n) threads_.emplace_back([this, n] { serve(n); });
}

Workers::~Workers() {
  stop_ = true;
  call(size());
  for (std::thread& thread : threads_) thread.join();
}

/// Sequentially consistent: either a thread that goes to sleep sees its new round, or it is seen
/// asleep.
void Workers::call(int parts) {
  for (int n = 1; n < parts; ++n) {
    Call& one = calls_[static_cast<std::size_t>(n)];
    one.round.store(one.round.load(std::memory_order_relaxed) + 1);
    if (one.asleep.load()) one.round.notify_one();
  }
}

void Workers::work_as(int number) noexcept {
  try {
    (*work_)(number);
  } catch (...) {
    thrown_[static_cast<std::size_t>(number)] = std::current_exception();
  }
}

void Workers::serve(int number) {
  Call& own = calls_[static_cast<std::size_t>(number)];
  for (std::uint32_t seen = 0;;) {
    if (!changes_soon(own.round, seen)) {
      own.asleep.store(true);
      own.round.wait(seen);
      own.asleep.store(false);
    }
    seen = own.round.load(std::memory_order_acquire);
    if (stop_) return;
    work_as(number);
    if (busy_.fetch_sub(1, std::memory_order_acq_rel) == 1) busy_.notify_all();
  }
}

void Workers::run(int parts, const std::function<void(int)>& work) {
  work_ = &work;
  busy_.store(parts - 1, std::memory_order_relaxed);
  call(parts);
  work_as(0);
  for (int left = busy_.load(std::memory_order_acquire); left != 0;
       left = busy_.load(std::memory_order_acquire))
    if (!changes_soon(busy_, left)) busy_.wait(left, std::memory_order_acquire);
  std::exception_ptr first;
  for (std::exception_ptr& thrown : thrown_) {
    if (!first) first = thrown;
    thrown = nullptr;
  }
  if (first) std::rethrow_exception(first);
}

void Workers::share(std::size_t count, std::size_t least,
                    const std::function<void(std::size_t, std::size_t)>& work) {
  const int parts = parts_of(count, least);
  if (parts == 1) return work(0, count);
  run(parts, [&](int n) {
    const auto part = static_cast<std::size_t>(n);
    const auto all = static_cast<std::size_t>(parts);
    work(count * part / all, count * (part + 1) / all);
  });
}

void Workers::take_turns(std::size_t count, const std::function<void(std::size_t)>& work) {
  const int parts = parts_of(count, 1);
  if (parts == 1) {
    for (std::size_t i = 0; i < count; ++i) work(i);
    return;
  }
  std::atomic<std::size_t> next{0};
  run(parts, [&](int) {
    for (std::size_t i = next.fetch_add(1, std::memory_order_relaxed); i < count;
         i = next.fetch_add(1, std::memory_order_relaxed))
      work(i);
  });
}

}  // namespace weft
